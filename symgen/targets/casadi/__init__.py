"""CasADi: programs to casadi.Function, and such functions read back for certificates."""

from symgen.targets.casadi.emit import casadi_function
from symgen.targets.casadi.numbers import CasadiNumbers
from symgen.targets.casadi.read_back import evaluate_mod, listing

__all__ = ["CasadiNumbers", "casadi_function", "evaluate_mod", "listing"]
