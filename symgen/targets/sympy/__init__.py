"""SymPy: readable matrices of every catalogue row, and equations as text, LaTeX and MathML."""

from symgen.targets.sympy.equations import equations
from symgen.targets.sympy.matrices import Equation, row_equation, sympy_matrix
from symgen.targets.sympy.paper import BlockMatrix, block_matrix
from symgen.targets.sympy.symbols import Symbols, system_symbols

__all__ = [
    "BlockMatrix",
    "Equation",
    "Symbols",
    "block_matrix",
    "equations",
    "row_equation",
    "sympy_matrix",
    "system_symbols",
]
