"""A compiled function as a Python function on NumPy arrays."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

DTYPES = {"double": np.float64, "float": np.float32}


class CompiledFunction:
    """Called with single states, ``q`` of shape (nq,), or with N of them, (N, nq); returns an array, or a tuple of
    arrays where there are several outputs, of shape ``shape`` or ``(N, *shape)``."""

    def __init__(self, row: Mapping[str, Any], entry: Any, defaults: Sequence[float]) -> None:
        self.__name__ = str(row["name"])
        self.inputs: tuple[str, ...] = tuple(port["name"] for port in row["inputs"])
        self.outputs: tuple[str, ...] = tuple(port["name"] for port in row["outputs"])
        self._shapes = {port["name"]: tuple(port["shape"]) for port in row["inputs"]}
        self._results = [tuple(port["shape"]) for port in row["outputs"]]
        self._dtype = DTYPES[row["precision"]]
        self._defaults = defaults
        self._entry = entry
        entry.restype = None
        entry.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p, ctypes.c_size_t] * len(self.inputs)]
        entry.argtypes += [ctypes.c_void_p] * len(self.outputs)
        self.__doc__ = _describe(row)

    def __repr__(self) -> str:
        return f"<{self.__name__}({', '.join(self.inputs)}) -> {', '.join(self.outputs)}>"

    def __call__(self, *args: Any, **named: Any) -> Any:
        """See the docstring of the object. ``p`` may be left out: the scene's values are used then.

        Raises TypeError for missing or unknown arguments, ValueError for wrong shapes and types.
        """
        arrays, count = self._broadcast(self._bind(args, named))
        single = count is None
        states = 1 if count is None else count
        results = [np.empty((states, *shape), self._dtype) for shape in self._results]
        pointers: list[Any] = []
        for name, array in arrays.items():
            per_state = array.ndim > len(self._shapes[name])
            pointers += [array.ctypes.data, prod(self._shapes[name]) if per_state else 0]
        self._entry(states, *pointers, *(result.ctypes.data for result in results))
        if single:
            results = [result[0] for result in results]
        return results[0] if len(results) == 1 else tuple(results)

    def _bind(self, args: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
        if len(args) > len(self.inputs):
            raise TypeError(f"{self!r} takes {len(self.inputs)} arguments, not {len(args)}")
        values = dict(zip(self.inputs, args, strict=False))
        for name, value in named.items():
            if name not in self.inputs or name in values:
                raise TypeError(f"{self!r} got {'a second' if name in values else 'an unknown'} argument {name}")
            values[name] = value
        if "p" in self.inputs and values.get("p") is None:
            values["p"] = self._defaults
        missing = [name for name in self.inputs if name not in values]
        if missing:
            raise TypeError(f"{self!r} needs {', '.join(missing)}")
        return {name: values[name] for name in self.inputs}

    def _broadcast(self, values: Mapping[str, Any]) -> tuple[dict[str, NDArray[Any]], int | None]:
        arrays: dict[str, NDArray[Any]] = {}
        count: int | None = None
        counted = ""
        for name, value in values.items():
            array = self._array(name, value)
            arrays[name] = array
            if array.ndim > len(self._shapes[name]):
                if count is not None and count != len(array):
                    message = f"{counted} is for {count} states, {name} for {len(array)}"
                    raise ValueError(f"{self.__name__}: {message}")
                count, counted = len(array), name
        return arrays, count

    def _array(self, name: str, value: Any) -> NDArray[Any]:
        shape = self._shapes[name]
        try:
            array = np.asarray(value)
            if array.dtype.kind not in "biuf":
                raise TypeError
        except (TypeError, ValueError):
            raise ValueError(f"{self.__name__}: {name} is no array of real numbers") from None
        if array.shape != shape and (array.ndim != len(shape) + 1 or array.shape[1:] != shape):
            batch = f"({', '.join(['N', *map(str, shape)])}{'' if shape else ','})"
            wanted = str(shape) if shape else "a number"
            raise ValueError(f"{self.__name__}: {name} must be {wanted} or {batch}, not {array.shape}")
        return np.ascontiguousarray(array, self._dtype).reshape(array.shape)


def _describe(row: Mapping[str, Any]) -> str:
    def port(item: Mapping[str, Any]) -> str:
        shape = " × ".join(map(str, item["shape"])) or "a number"
        return f"    {item['name']}: {shape}" + (f", {item['unit']}" if item["unit"] else "")

    operations = ", ".join(f"{n} {name}" for name, n in row["operations"].items() if n) or "none"
    lines = [
        f"{row['name']}: {', '.join(p['name'] for p in row['inputs'])} → "
        f"{', '.join(p['name'] for p in row['outputs'])}",
        "",
        *(["Inputs (each also with a leading axis of N states):"] if row["inputs"] else ["No inputs."]),
        *map(port, row["inputs"]),
        "Outputs:",
        *map(port, row["outputs"]),
        f"Plan: {row['plan'] or 'as defined'}; operations: {operations}; {row['precision']} precision.",
    ]
    return "\n".join(lines)
