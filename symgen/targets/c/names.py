"""Names inside one C file: unique, never a reserved word, never one of the C library's."""

from __future__ import annotations

from collections.abc import Iterable

from symgen.scene.names import RESERVED, identifier

_HELPERS = """sines_cosines four four_apart four_bits four_slowly angles sines cosines sine_cosine sine_cosine_reduced
sine_cosine_slowly sine cosine cos_sqrt sinc_sqrt sinc3_sqrt square_root_tail reduce_large multiply_high
two_over_pi i n show w"""
HELPERS = frozenset(_HELPERS.split())
"""Functions of symgen's own files, and the variables of its loops."""

_LIBRARY = """sinf
cosf sqrtf fabsf ldexpf frexpf j0f j1f jnf y0f y1f ynf sincosf exp10 pow10 drem finite significand scalb
scalbln ilogb llrint llround fmin fmax remquo nexttoward float_t double_t int32_t uint32_t uint64_t ptrdiff_t"""

_TAKEN = frozenset(word.lower() for word in RESERVED | HELPERS) | frozenset(_LIBRARY.split())


class Names:
    """Hands out identifiers, each once."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)
        self._next: dict[str, int] = {}

    @property
    def taken(self) -> frozenset[str]:
        return frozenset(self._taken)

    def take(self, wanted: str) -> str:
        """``wanted`` if it is free, else ``wanted_2``, ``wanted_3``, …"""
        base = identifier(wanted)
        name = base
        number = self._next.get(base, 2)
        while name in self._taken or name.lower() in _TAKEN:
            name = f"{base.rstrip('_')}_{number}"
            number += 1
        self._next[base] = number
        self._taken.add(name)
        return name

    def take_numbered(self, stem: str, number: int) -> str:
        """``stem`` with its number; quicker than `take` for the many temporaries."""
        name = f"{stem}{number}"
        if name in self._taken or name in _TAKEN:
            return self.take(name)
        self._taken.add(name)
        return name
