"""C99: programs to readable source, and source read back for certificates."""

from symgen.targets.c.emit import Emitted, EmittedFunction, emit_c
from symgen.targets.c.info import Info, JointRow

__all__ = ["Emitted", "EmittedFunction", "Info", "JointRow", "emit_c"]
