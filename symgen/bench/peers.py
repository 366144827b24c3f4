"""The same functions by other programs, built from the same scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from symgen.bench.result import EMPTY_CALL
from symgen.errors import NotSupportedError, ToolError
from symgen.scene.model import Scene

OVERHEAD_NOTE = (
    "pinocchio is called through its own Python binding, one state a call, and its times include that call "
    "('empty call' is the cheapest there is); ours run in a compiled loop over the batch"
)


def pinocchio_calls(scene: Scene, states: Sequence[Mapping[str, Any]]) -> dict[str, Callable[[], None]]:
    """Function name → a call that evaluates Pinocchio at every state, in Pinocchio's own coordinates; empty when it is
    not installed. ``empty call`` is the cheapest call through the same binding."""
    from symgen.validation.pinocchio_model import build_pinocchio

    try:
        adapter = build_pinocchio(scene)
    except (ToolError, NotSupportedError):
        return {}
    pin, model, data = adapter.pin, adapter.model, adapter.data
    if adapter.mechanism.nv != model.nv:
        return {}

    def over(run: Callable[[Mapping[str, Any]], object]) -> Callable[[], None]:
        def loop() -> None:
            for state in states:
                run(state)

        return loop

    return {
        "mass_matrix": over(lambda s: pin.crba(model, data, s["q"])),
        "bias_force": over(lambda s: pin.nonLinearEffects(model, data, s["q"], s["v"])),
        "inverse_dynamics": over(lambda s: pin.rnea(model, data, s["q"], s["v"], s["a"])),
        "forward_dynamics": over(lambda s: pin.aba(model, data, s["q"], s["v"], s["tau"])),
        EMPTY_CALL: over(lambda s: model.existJointName("")),
    }
