"""The built-in functions of the C file, as functions of a device."""

from __future__ import annotations

import re
from collections.abc import Collection

from symgen.targets.c.sincos import ENTIRE, ENTIRE_ULPS, KERNELS, device_numbers, polynomial
from symgen.targets.c.templates import render

_DEEPER = "\n            "


def device_functions(precision: str, trigonometry: str, called: Collection[str]) -> str:
    """The text of the functions that a file needs which calls ``called``, operation by operation those of the C file.
    May be empty."""
    own = trigonometry == "polynomial"
    entire = [name for name in ENTIRE if name in called]
    numbers = device_numbers(precision)
    real, f = numbers["real"], numbers["f"]
    text = ""
    if own and (entire or {"sine_cosine", "sine", "cosine"} & set(called)):
        text += render(f"c/reduce_{precision}.c.j2", words=numbers["words"])
        text += render("cuda/sine_cosine.j2", parts=called, **numbers)
    if entire:
        kernel = KERNELS[precision]
        pair = (
            f"{real} s, c;\n        sine_cosine(y, &s, &c);" if own else f"const {real} s = sin{f}(y), c = cos{f}(y);"
        )
        text += render(
            "c/entire.c.j2",
            parts=entire,
            pair=pair,
            entire_ulps=ENTIRE_ULPS[precision],
            sine_x=polynomial(kernel.sine, "x", _DEEPER),
            cosine_x=polynomial(kernel.cosine, "x", _DEEPER),
            sinc3_x=polynomial(kernel.sinc3, "x", _DEEPER),
            **numbers,
        )
    text = text.replace("static const uint32_t two_over_pi[", "SYMGEN_TABLE uint32_t two_over_pi[")
    text = text.replace("static unsigned reduce_large(", "SYMGEN_APART unsigned reduce_large(")
    return re.sub(r"^static ", "SYMGEN_DEVICE ", text, flags=re.MULTILINE).rstrip("\n")
