"""A step as a `ComposedProgram`: every update derived exactly, every row a call of its emitted function."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from symgen.catalogue import Sizes, function_name, function_summary, input_ports, output_ports, split_row
from symgen.integrators.methods import METHODS
from symgen.integrators.model import Evaluate, Method, Place, Update
from symgen.plans.walk import Lowered
from symgen.program.composed import Call, ComposedProgram
from symgen.program.graph import Graph, extract
from symgen.program.instructions import Port, Program
from symgen.program.passes import optimise
from symgen.scene.model import Output
from symgen.velocity.values import Values

OWN = "step"
"""Row of the catalogue: step:METHOD."""


def is_step(output: Output) -> bool:
    return any(split_row(row)[0] == OWN for row in output.of)


def method_of(output: Output) -> Method:
    return METHODS[split_row(output.of[0])[1]]


def needed_rows(outputs: tuple[Output, ...]) -> tuple[Output, ...]:
    """Functions that steps among ``outputs`` call and that are not among them."""
    there = {output.name for output in outputs}
    rows = dict.fromkeys(row for output in outputs if is_step(output) for row in method_of(output).rows)
    return tuple(Output(row, (row,)) for row in rows if row not in there)


def without_steps(outputs: tuple[Output, ...]) -> tuple[Output, ...]:
    """The others, and what the steps call."""
    return (*(output for output in outputs if not is_step(output)), *needed_rows(outputs))


def compose(lowered: Lowered, size: Sizes, output: Output, program_of: Callable[[str], Program]) -> ComposedProgram:
    """The step. ``program_of``: row → what its function is emitted from."""
    method = method_of(output)
    inputs, outputs = input_ports(output.of, size), output_ports(output.of, size)
    arrays = {port.name: port for port in (*inputs, *outputs)}
    own = {name: Port(name, tuple(int(getattr(size, n)) for n in shape)) for name, shape in method.locals.items()}
    callees = {row: program_of(row) for row in method.rows}
    maker = _Maker(lowered, arrays | own, {})
    calls = tuple(
        maker.call(operation) if isinstance(operation, Update) else _evaluate(operation, callees[operation.row])
        for operation in method.operations
    )
    return ComposedProgram(
        function_name(output.name),
        inputs,
        outputs,
        (),
        ((),) * len(outputs),
        (0,) if any(program.guards for program in callees.values()) else (),
        f"{method.plan}, calls {', '.join(method.rows)}",
        function_summary(output),
        calls,
        own,
        callees,
    )


def _evaluate(operation: Evaluate, program: Program) -> Call:
    inputs = {port.name: operation.inputs.get(port.name, "p") for port in program.inputs if port.size}
    return Call(program.name, inputs, operation.outputs)


class _Maker:
    """Derives updates, one program for all of one name."""

    def __init__(self, lowered: Lowered, arrays: Mapping[str, Port], made: dict[str, Program]) -> None:
        self.lowered, self.arrays, self.made = lowered, arrays, made

    def call(self, update: Update) -> Call:
        if update.name not in self.made:
            self.made[update.name] = self.program(update)
        program = self.made[update.name]
        inputs = {port.name: update.inputs.get(port.name, "p") for port in program.inputs}
        return Call(program.name, inputs, update.outputs, program)

    def program(self, update: Update) -> Program:
        """What an update computes, from what it reads."""
        graph, tree = Graph(), self.lowered.tree
        ports = {port: Port(port, self.arrays[array].shape) for port, array in update.inputs.items()}
        if "p" in self.arrays:
            ports["p"] = self.arrays["p"]
        values = {name: graph.inputs(name, port.size) for name, port in ports.items()}
        place = Place(tree, Values(self.lowered.scene, graph, values.get("p", ())), sparse=True)
        outputs = tuple(Port(port, self.arrays[array].shape) for port, array in update.outputs.items())
        program = extract(graph, update.name, tuple(ports.values()), outputs, update.function(place, values))
        graph.forget()
        program = optimise(program)
        read = {step.value[0] for step in program.instructions if step.op == "input" and isinstance(step.value, tuple)}
        kept = tuple(port for port in program.inputs if port.name in read)
        return Program(program.name, kept, outputs, program.instructions, program.results)
