"""Joints that mimic others: what such a coupling must be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symgen.errors import SceneError
from symgen.scene.document import Places, clean
from symgen.scene.model import Joint
from symgen.scene.schema import did_you_mean

COUPLED = ("revolute", "continuous", "prismatic")
"""Types of joint that may mimic, and be mimicked."""


def check_mimics(joints: Sequence[Joint], places: Places) -> None:
    """Raise SceneError for the first coupling that is none: between what kinds of joint, in a circle, across a cut."""
    known = {joint.name: joint for joint in joints}
    for i, joint in enumerate(joints):
        if joint.mimic is None:
            continue
        problem = _problem(joint, known) or _at_a_cut(joint, known, joints)
        if problem:
            raise SceneError(f"joint {clean(joint.name)!r} {problem}", places.place(("joints", i, "mimic")))


def _problem(joint: Joint, known: Mapping[str, Joint]) -> str:
    mimic = joint.mimic
    assert mimic is not None
    name = clean(mimic.joint)
    if mimic.joint not in known:
        meant = did_you_mean(mimic.joint, [name for name, other in known.items() if other.type in COUPLED])
        return f"mimics {name!r}, but there is no such joint{meant}"
    if mimic.joint == joint.name:
        return "mimics itself"
    master = known[mimic.joint]
    if joint.type not in COUPLED:
        return f"is {joint.type}; only {', '.join(COUPLED)} joints can mimic"
    if master.type == "fixed":
        return f"mimics {name!r}, which is fixed: lock it at a position instead"
    if master.type not in COUPLED:
        return f"mimics {name!r}, which is {master.type}; only {', '.join(COUPLED)} joints can be mimicked"
    if mimic.multiplier == 0:
        return f"mimics {name!r} with the multiplier 0, so it does not move: make it fixed"
    chain = [joint.name]
    while master.mimic is not None and master.mimic.joint in known:
        chain.append(master.name)
        if master.mimic.joint in chain:
            return f"mimics in a circle: {' → '.join(clean(each) for each in (*chain, master.mimic.joint))}"
        master = known[master.mimic.joint]
    return ""


def _at_a_cut(joint: Joint, known: Mapping[str, Joint], joints: Sequence[Joint]) -> str:
    """A cut joint has no coordinate, so neither side of a coupling may be one, or be in danger of it."""
    assert joint.mimic is not None
    for side in (joint, known[joint.mimic.joint]):
        if side.cut:
            return f"cannot be coupled across a cut: {clean(side.name)!r} is cut and has no coordinate"
        rival = next((other for other in joints if other.child == side.child and other is not side), None)
        if rival is not None and not rival.cut:
            return (
                f"is coupled across a closed loop, which may be cut at {clean(side.name)!r}: mark another of its "
                f"joints, such as {clean(rival.name)!r}, with 'cut: true'"
            )
    return ""


def root_of_mimics(joint: Joint, known: Mapping[str, Joint]) -> tuple[str, Fraction, Fraction]:
    """(master, multiplier, offset): the joint at the end of a chain of mimics, and where it takes this one.

    A chain that goes round or ends nowhere gives the name it stops at; `check_mimics` says what is wrong with it.
    """
    multiplier, offset, seen = Fraction(1), Fraction(0), {joint.name}
    while joint.mimic is not None:
        offset += multiplier * joint.mimic.offset
        multiplier *= joint.mimic.multiplier
        if joint.mimic.joint in seen or joint.mimic.joint not in known:
            return joint.mimic.joint, multiplier, offset
        seen.add(joint.mimic.joint)
        joint = known[joint.mimic.joint]
    return joint.name, multiplier, offset
