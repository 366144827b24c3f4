"""A scene written in Python, with the same rules, checks and messages as a scene file.

>>> scene = (
...     SceneBuilder("pendulum")
...     .body("rod", mass="1.2", com=(0, 0, -0.5), inertia=(0.1, 0.1, 0, 0, 0, 0))
...     .joint("hinge", "revolute", "ground", "rod", axis=(0, 1, 0))
...     .build()
... )

A number is an int, Fraction, Decimal, a text such as "0.1", or a float. A float stands for the decimal
that Python prints for it: 0.1 is 1/10 exactly, as it would be in a file.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import deepcopy
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Rational, Real
from os import PathLike
from pathlib import Path
from typing import Any, Self

from symgen.errors import SceneError
from symgen.scene.assemble import assemble
from symgen.scene.document import Document, clean, dotted
from symgen.scene.exact import check_range, decimal
from symgen.scene.model import Scene

Number = int | float | str | Fraction | Decimal
Numbers = Iterable[Number]


def exact(value: Any) -> Fraction:
    """The rational a number stands for; ValueError (TypeError) when it is none, or not finite."""
    if isinstance(value, bool) or not isinstance(value, str | Decimal | Real):
        raise TypeError(f"a number is wanted, not {clean(repr(value))}")
    if isinstance(value, Integral):
        return check_range(Fraction(int(value)))
    if isinstance(value, Rational):
        return check_range(Fraction(int(value.numerator), int(value.denominator)))
    return decimal(str(value).strip())  # of a float (NumPy's too) the shortest decimal that reads back as it


class SceneBuilder:
    """Collects the parts of a scene; every method returns the builder, ``build`` the validated Scene.

    Arguments have the names, units and defaults of the scene file. SceneError names the part that is wrong.
    """

    def __init__(self, name: str, gravity: Numbers | None = None) -> None:
        self._name = name
        self._data: dict[str, Any] = {"name": name}
        if gravity is not None:
            self._data["gravity"] = self._list(gravity, "gravity")

    def body(
        self,
        name: str,
        mass: Number = 0,
        com: Numbers = (0, 0, 0),
        inertia: Numbers | Mapping[str, Number] = (0,) * 6,
        basic_points: Iterable[Numbers] = (),
        unit_vectors: Iterable[Numbers] = (),
    ) -> Self:
        """A rigid body: kg, m in body axes, kg·m² about the centre of mass (ixx, iyy, izz, ixy, ixz, iyz)."""
        where = self._where("bodies")
        return self._add("bodies", {
            "name": name,
            "mass": self._number(mass, f"{where}.mass"),
            "com": self._list(com, f"{where}.com"),
            "inertia": self._inertia(inertia, f"{where}.inertia"),
            "basic_points": [self._list(point, f"{where}.basic_points") for point in basic_points],
            "unit_vectors": [self._list(vector, f"{where}.unit_vectors") for vector in unit_vectors],
        })  # fmt: skip

    def joint(
        self,
        name: str,
        type: str,
        parent: str,
        child: str,
        *,
        axis: Numbers | None = None,
        axis2: Numbers | None = None,
        pitch: Number | None = None,
        xyz: Numbers = (0, 0, 0),
        rpy: Numbers = (0, 0, 0),
        armature: Number | None = None,
        damping: Number | None = None,
        cut: bool | None = None,
        limits: Mapping[str, Number] | None = None,
        mimic: Mapping[str, Any] | None = None,
    ) -> Self:
        """A joint: ``xyz`` (m) and ``rpy`` (rad) place its frame in the parent's; axes are in the joint frame.

        ``mimic``: ``{"joint": "j1", "multiplier": -1, "offset": 0}`` moves it with another joint.
        """
        where = self._where("joints")
        item: dict[str, Any] = {"name": name, "type": type, "parent": parent, "child": child}
        item["origin"] = self._origin(xyz, rpy, where)
        for key, vector in (("axis", axis), ("axis2", axis2)):
            if vector is not None:
                item[key] = self._list(vector, f"{where}.{key}")
        for key, value in (("pitch", pitch), ("armature", armature), ("damping", damping)):
            if value is not None:
                item[key] = self._number(value, f"{where}.{key}")
        if cut is not None:
            item["cut"] = cut
        if limits is not None:
            item["limits"] = {key: self._number(value, f"{where}.limits.{key}") for key, value in limits.items()}
        if mimic is not None:
            item["mimic"] = {
                key: value if key == "joint" else self._number(value, f"{where}.mimic.{key}")
                for key, value in mimic.items()
            }
        return self._add("joints", item)

    def spring(
        self,
        between: Iterable[str],
        points: Iterable[Numbers],
        *,
        stiffness: Number = 0,
        damping: Number = 0,
        length: Number = 0,
        name: str | None = None,
    ) -> Self:
        """A spring–damper along the line between two points, each in its body's frame (``ground`` allowed)."""
        where = self._where("forces")
        item: dict[str, Any] = {"type": "spring", "between": list(between)}
        item["points"] = [self._list(point, f"{where}.points") for point in points]
        for key, value in (("stiffness", stiffness), ("damping", damping), ("length", length)):
            item[key] = self._number(value, f"{where}.{key}")
        return self._add("forces", item if name is None else {"name": name, **item})

    def joint_spring(
        self, joint: str, *, stiffness: Number = 0, damping: Number = 0, rest: Number = 0, name: str | None = None
    ) -> Self:
        """A spring–damper on every coordinate of a joint."""
        where = self._where("forces")
        item: dict[str, Any] = {"type": "joint_spring", "joint": joint}
        for key, value in (("stiffness", stiffness), ("damping", damping), ("rest", rest)):
            item[key] = self._number(value, f"{where}.{key}")
        return self._add("forces", item if name is None else {"name": name, **item})

    def frame(self, name: str, body: str, xyz: Numbers = (0, 0, 0), rpy: Numbers = (0, 0, 0)) -> Self:
        """A named frame fixed in a body."""
        origin = self._origin(xyz, rpy, self._where("frames"))
        return self._add("frames", {"name": name, "body": body, "origin": origin})

    def parameters(self, *names: str) -> Self:
        """Numbers that become run-time arguments: ``"rod.mass"``, ``"gravity"``, …"""
        self._data.setdefault("parameters", []).extend(names)
        return self

    def outputs(self, *rows: str, **combined: Iterable[str]) -> Self:
        """Functions to make: catalogue rows, and ``name=[row, row]`` for several in one function."""
        items = [*rows, *({"name": name, "of": list(of)} for name, of in combined.items())]
        self._data.setdefault("outputs", []).extend(items)
        return self

    def options(self, **options: Any) -> Self:
        """Base velocity, precision, trigonometry, snap, status, batch, code, targets: as in a scene's options."""
        if "snap" in options:
            options["snap"] = self._number(options["snap"], "options.snap")
        if "targets" in options:
            options["targets"] = list(options["targets"])
        self._data.setdefault("options", {}).update(options)
        return self

    def lock(self, **positions: Number | Numbers) -> Self:
        """Joints held at a position (a list for joints with several coordinates)."""
        held = self._data.setdefault("lock", {})
        for joint, value in positions.items():
            where = dotted(("lock", joint))
            alone = isinstance(value, str) or not isinstance(value, Iterable)
            held[joint] = self._number(value, where) if alone else self._list(value, where)
        return self

    def model(self, path: str | PathLike[str], base: str = "fixed", remove: Iterable[str] = ()) -> Self:
        """A URDF file that the scene's own bodies and joints are added to; its bodies in ``remove`` are left out."""
        self._data.update({"model": str(Path(path)), "base": base, "remove": list(remove)})
        return self

    def build(self) -> Scene:
        """The validated Scene. Raises SceneError for the first thing that is wrong."""
        return assemble(Document(deepcopy(self._data), self._file()), Path())

    # -- inside ----------------------------------------------------------------------------------------------------

    def _file(self) -> str:
        return f"scene {clean(str(self._name))!r}"

    def _where(self, kind: str) -> str:
        return f"{kind}[{len(self._data.get(kind, []))}]"

    def _add(self, kind: str, item: dict[str, Any]) -> Self:
        self._data.setdefault(kind, []).append(item)
        return self

    def _number(self, value: Any, where: str) -> Fraction:
        try:
            return exact(value)
        except (TypeError, ValueError) as error:
            raise SceneError(str(error), f"{self._file()}: {where}") from None

    def _list(self, values: Any, where: str) -> list[Fraction]:
        if isinstance(values, str | Mapping) or not isinstance(values, Iterable):
            raise SceneError(f"a list of numbers is wanted, not {clean(repr(values))}", f"{self._file()}: {where}")
        return [self._number(value, f"{where}[{i}]") for i, value in enumerate(values)]

    def _inertia(self, values: Any, where: str) -> list[Fraction] | dict[str, Fraction]:
        if not isinstance(values, Mapping):
            return self._list(values, where)
        return {str(key): self._number(value, f"{where}.{key}") for key, value in values.items()}

    def _origin(self, xyz: Numbers, rpy: Numbers, where: str) -> dict[str, Any]:
        return {"xyz": self._list(xyz, f"{where}.origin.xyz"), "rpy": self._list(rpy, f"{where}.origin.rpy")}


__all__ = ["Number", "SceneBuilder", "exact"]
