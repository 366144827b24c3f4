"""What the benchmark problems are, where their right answers come from, and what others print, in words."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Statement:
    """``answer``: the closed form or the published value; ``source``: where it stands; ``published``: accuracy or time
    that others give."""

    words: str
    answer: str
    source: str
    published: str = ""


STATEMENTS: dict[str, Statement] = {
    "A01 simple pendulum": Statement(
        "A point mass of 1 kg on a massless bar of 1 m is released at rest when horizontal, and swings for 10 s, and "
        "for 2,000 s: 845 periods, over which errors of frequency add up.",
        "θ = 2 asin(k sn(ω₀ t + K, k)) with ω₀² = g/l and k = sin(θ₀/2).",
        "IFToMM benchmark library, problem A01; Landau & Lifshitz, Mechanics, § 11",
        "OpenSim 3.2 takes 0.637 s for the 10 s (Intel i5-4570), and plots energy and positions without figures.",
    ),
    "rod pendulum": Statement(
        "A brick of 1 × 0.1 × 0.1 m and 1000 kg/m³ on a hinge at the middle of one end is released at rest when "
        "horizontal.",
        "Its angle after 1 s is −3.13401855180855.",
        "Exudyn's own suite of tests, stored result of its kinematic tree",
        "15 digits.",
    ),
    "free rigid body": Statement(
        "A body with moments of inertia 1, 2, 3 kg m² tumbles without forces.",
        "ω in Jacobi's elliptic functions cn, sn, dn.",
        "Landau & Lifshitz, Mechanics, § 37",
    ),
    "Dzhanibekov's flips": Statement(
        "The same body, spun about its middle axis with ω = (0.001, 1, 0.001) rad/s: it turns over and back for ever.",
        "ω repeats after 4 K/λ = 55.061681107466372 s.",
        "Landau & Lifshitz, Mechanics, § 37",
    ),
    "axisymmetric free body": Statement(
        "A body with two equal moments precesses steadily while it spins.",
        "Two rotations: about the angular momentum with |L|/I₁, and about its own axis with ω₃ (I₁ − I₃)/I₁.",
        "Kane & Levinson, Dynamics: Theory and Applications, § 3; Landau & Lifshitz, Mechanics, § 35",
    ),
    "symmetric top": Statement(
        "A top leans by 0.5 rad and precesses with 4 rad/s; it is started with exactly the spin for which it does not "
        "nod.",
        "(L₃ − I₁ Ω cos θ) Ω = m g l, θ constant.",
        "Goldstein, Poole & Safko, Classical Mechanics, § 5.7",
    ),
    "sleeping top": Statement(
        "An upright top is disturbed by a microradian. It sleeps if it spins fast enough, else it falls: two runs, 2 % "
        "above and below the limit.",
        "Stable where L₃² > 4 I₁ m g l; near it the axis follows I₁ z̈ − i L₃ ż − m g l z = 0.",
        "Goldstein, Poole & Safko, Classical Mechanics, § 5.7",
    ),
    "heavy top": Statement(
        "A fast top of 15 kg whose centre of mass is 1 m from its tip, ω = (0, 150, −4.61538) rad/s.",
        "Euler parameters after 0.2 s: (0.43878109, 0.5457284, 0.08939975, −0.70827915).",
        "Exudyn's own suite of tests, stored result",
        "8 digits.",
    ),
    "damped oscillator": Statement(
        "A mass on a spring and a damper.",
        "x = x₀ exp(−d t) (cos ω t + d/ω sin ω t).",
        "any textbook",
    ),
    "two masses, three springs": Statement(
        "Two masses between walls on three springs.",
        "Modes of 3 and 5 rad/s, together and against one another.",
        "any textbook",
    ),
    "zigzag chain of 10": Statement(
        "Ten equal rods hang in a zigzag and are let go: a chain whose accelerations need the whole mass matrix.",
        "Its energy stays; solvers and steps come to the same place.",
        "after the chains of Featherstone, Rigid Body Dynamics Algorithms, § 10",
    ),
    "tumbling pair": Statement(
        "A lopsided body floats without weight and carries another one on a ball joint; both tumble for 10,000 s. Two "
        "implicit steps of order 2 are compared: the variational one, and the midpoint rule in q and v.",
        "Energy, linear and angular momentum (about the origin) stay what they were.",
        "Marsden & West, Acta Numerica 2001: a discrete action that does not change when everything is turned keeps "
        "momenta exactly, and energy within a band",
    ),
    "double pendulum": Statement(
        "Two rods swing high. The motion is chaotic, so that two correct programs part: rounding grows e-fold in half "
        "a second.",
        "Pinocchio's accelerations in the same steps agree to 1e-3 for about 15 s; nobody can do better in double.",
        "Pinocchio, articulated bodies",
    ),
    "A05 stiff flyball governor": Statement(
        "Watt's governor, its couplers replaced by springs of 800 kN/m with dampers of 40 kN s/m: stiff, and here a "
        "tree.",
        "Solvers agree; with rigid couplers one coordinate is left, s = 1 − sin β with angular momentum kept.",
        "IFToMM benchmark library, problem A05",
        "OpenSim 3.2 plots s over 10 s beside the library's reference, without figures.",
    ),
}
