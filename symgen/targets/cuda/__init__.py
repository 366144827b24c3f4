"""CUDA: one thread a state, with the statements of the C functions; source read back for certificates."""

from symgen.targets.cuda.emit import CudaFunction, EmittedCuda, emit_cuda
from symgen.targets.cuda.read_back import read_cuda

__all__ = ["CudaFunction", "EmittedCuda", "emit_cuda", "read_cuda"]
