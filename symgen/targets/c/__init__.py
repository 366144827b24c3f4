"""C99: programs to readable source, and source read back for certificates."""

from symgen.targets.c.emit import Emitted, EmittedFunction, emit_c
from symgen.targets.c.function_text import ReadFunction
from symgen.targets.c.info import Info, JointRow
from symgen.targets.c.read_back import ReadBack, read_back

__all__ = ["Emitted", "EmittedFunction", "Info", "JointRow", "ReadBack", "ReadFunction", "emit_c", "read_back"]
