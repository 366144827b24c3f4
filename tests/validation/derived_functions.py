"""Functions of the catalogue as CasADi evaluates them: the derivation without a C compiler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from symgen.errors import SymgenError
from symgen.scene.model import Scene
from symgen.system import derive
from symgen.validation import wanted_outputs

Call = Callable[..., Any]


class DerivedFunctions:
    """One attribute per function, on (n,) or (N, n) arrays; what the scene cannot have is missing."""

    def __init__(self, scene: Scene) -> None:
        outputs = wanted_outputs(scene)
        system = derive(replace(scene, outputs=outputs))
        for output in outputs:
            try:
                function = system.casadi(output.name)
            except SymgenError:
                continue
            ports = system.program(output.name).outputs
            setattr(self, output.name, self._wrap(function, [port.shape for port in ports]))
            getattr(self, output.name).outputs = tuple(port.name for port in ports)

    @staticmethod
    def _wrap(function: Any, shapes: list[tuple[int, ...]]) -> Call:
        names = [function.name_in(k) for k in range(function.n_in())]

        def one(*arguments: Any) -> Any:
            values = function.call(list(arguments))
            found = tuple(value.full().reshape(shape) for value, shape in zip(values, shapes, strict=True))
            return found[0] if len(found) == 1 else found

        def call(*arguments: Any, p: Any = None) -> Any:
            def with_p(rows: Any) -> list[Any]:
                given = iter(rows)
                return [p if name == "p" else next(given) for name in names]

            if not arguments or np.ndim(arguments[0]) == 1:
                return one(*with_p(arguments))
            return np.array([one(*with_p(rows)) for rows in zip(*arguments, strict=True)])

        call.inputs = tuple(names)  # type: ignore[attr-defined]
        return call
