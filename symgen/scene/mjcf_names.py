"""Names for the bodies and joints of an MJCF model: the file's own, and readable ones for those that have none.

They depend on names, types and order alone, so whoever has the compiled model finds the same names again.
"""

from __future__ import annotations

from collections.abc import Sequence

from symgen.scene.model import GROUND

LONGEST = 120
"""Characters of a name that another name is made from."""


def unused(name: str, taken: set[str]) -> str:
    """``name``, numbered when it is taken; from then on it is."""
    text, count = name, 1
    while text in taken:
        count += 1
        text = f"{name}_{count}"
    taken.add(text)
    return text


def joined(*parts: str) -> str:
    """``body_joint``."""
    return "_".join(part[:LONGEST] for part in parts)


def body_names(names: Sequence[str]) -> tuple[str, ...]:
    """Names of the bodies of a model in MuJoCo's order, the world (``ground`` here) first.

    A body without a name is ``body_7`` after its place in that order; one called ``ground`` is ``ground_2``.
    """
    taken = {GROUND, *names[1:]}
    result = [GROUND]
    for index, name in enumerate(names[1:], start=1):
        result.append(name if name not in ("", GROUND) else unused(name or f"body_{index}", taken))
    return tuple(result)


def joint_names(names: Sequence[str], types: Sequence[str], bodies: Sequence[str]) -> tuple[str, ...]:
    """Names of the joints in MuJoCo's order; ``bodies`` are the (final) names of the bodies they move.

    A joint without a name is ``hand_hinge`` after its body and type, and the next such one ``hand_hinge_2``.
    """
    taken = {GROUND, *names}
    return tuple(
        name if name not in ("", GROUND) else unused(name or joined(body, kind), taken)
        for name, kind, body in zip(names, types, bodies, strict=True)
    )
