"""Work–precision: CPU time against global error of our integrators beside others, orders, and energy over long runs.

    python -m symgen.validation.work_precision SCENE … -o DIR

Per scene one motion from one generic start, everything in one run. Error: largest difference of link positions (m) and
entries of rotation matrices at its end from one reference, whose own uncertainty is measured; where energy is kept, its
relative change besides. Time: CPU time of the integration alone, without deriving, compiling, building models and
energies. Exudyn and the generated steps loop inside C++ and C; SciPy calls the right-hand side, ours or Pinocchio's,
from Python.
"""

from symgen.validation.work_precision.data import FULL, QUICK, Effort, precision_data

__all__ = ["FULL", "QUICK", "Effort", "precision_data"]
