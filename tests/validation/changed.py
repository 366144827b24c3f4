"""Functions with one of them spoilt: every check must be seen to fail."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Changed:
    """``functions`` with ``name``'s result put through ``change(result, *arguments)``."""

    def __init__(self, functions: Any, name: str, change: Callable[..., Any]) -> None:
        self._functions, self._name, self._change = functions, name, change

    def __getattr__(self, name: str) -> Any:
        function = getattr(self._functions, name)
        if name != self._name:
            return function

        def changed(*arguments: Any, **more: Any) -> Any:
            return self._change(function(*arguments, **more), *arguments)

        for names in ("inputs", "outputs"):
            if hasattr(function, names):
                setattr(changed, names, getattr(function, names))
        return changed


class Without:
    """``functions`` less some of them."""

    def __init__(self, functions: Any, *names: str) -> None:
        self._functions, self._names = functions, names

    def __getattr__(self, name: str) -> Any:
        if name in self._names:
            raise AttributeError(name)
        return getattr(self._functions, name)
