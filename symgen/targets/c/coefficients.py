"""Numbers of the built-in trigonometry. Written by tools/sincos_coefficients.py: change that, not this."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kernel:
    """C literals: polynomials in y² by rising power, and the parts of π/2."""

    sine: tuple[str, ...]
    """(sin y / y − 1) / y² for |y| ≤ HALF_RANGE."""
    cosine: tuple[str, ...]
    """(cos y − 1 + y²/2) / y⁴ for |y| ≤ HALF_RANGE."""
    sinc3: tuple[str, ...]
    """(y − sin y) / y³ for y² ≤ SINC3_RANGE."""
    half_pi: tuple[str, ...]


HALF_RANGE = "0.7864"
SINC3_RANGE = "4"

DOUBLE = Kernel(
    sine=(
        "-0.16666666666666630",
        "0.0083333333333218407",
        "-0.00019841269829358525",
        "2.7557313538512764e-6",
        "-2.5050734389013597e-8",
        "1.5895433277812973e-10",
    ),
    cosine=(
        "0.041666666666666595",
        "-0.0013888888888873296",
        "2.4801587288953846e-5",
        "-2.7557314198804994e-7",
        "2.0875702453515863e-9",
        "-1.1358577036971123e-11",
    ),
    sinc3=(
        "0.16666666666666666",
        "-0.0083333333333333332",
        "0.00019841269841269841",
        "-2.7557319223985888e-6",
        "2.5052108385441101e-8",
        "-1.6059043836750261e-10",
        "7.6471637266665963e-13",
        "-2.8114570150488138e-15",
        "8.2205637699558278e-18",
        "-1.9559660161344468e-20",
        "3.7282258815166713e-23",
    ),
    half_pi=(
        "1.5707963267923333",
        "2.5633441514780767e-12",
        "1.1644211747377496e-22",
    ),
)

FLOAT = Kernel(
    sine=(
        "-0.166666552f",
        "0.00833218731f",
        "-0.000195178931f",
    ),
    cosine=(
        "0.0416666456f",
        "-0.00138873095f",
        "2.44323273e-5f",
    ),
    sinc3=(
        "0.166666672f",
        "-0.00833333377f",
        "0.000198412614f",
        "-2.75564730e-6f",
        "2.50116123e-8f",
        "-1.51594876e-10f",
    ),
    half_pi=(
        "1.57055664f",
        "0.000239670277f",
        "1.58932547e-8f",
    ),
)

TWO_OVER_PI = (
    0x00000000,
    0x00000000,
    0x00000000,
    0xA2F9836E,
    0x4E441529,
    0xFC2757D1,
    0xF534DDC0,
    0xDB629599,
    0x3C439041,
    0xFE5163AB,
    0xDEBBC561,
    0xB7246E3A,
    0x424DD2E0,
    0x06492EEA,
    0x09D1921C,
    0xFE1DEB1C,
    0xB129A73E,
    0xE88235F5,
    0x2EBB4484,
    0xE99C7026,
    0xB45F7E41,
    0x3991D639,
    0x835339F4,
    0x9C845F8B,
    0xBDF9283B,
    0x1FF897FF,
    0xDE05980F,
    0xEF2F118B,
    0x5A0A6D1F,
    0x6D367ECF,
    0x27CB09B7,
    0x4F463F66,
    0x9E5FEA2D,
    0x7527BAC7,
    0xEBE5F17B,
    0x3D0739F7,
    0x8A5292EA,
    0x6BFB5FB1,
    0x1F8D5D08,
    0x56033046,
    0xFC7B6BAB,
)
"""2/π in words of 32 bits, after three words of nothing."""
