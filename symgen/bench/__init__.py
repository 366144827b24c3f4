"""``symgen bench``: speed and error of the generated C, beside the peers that are installed."""

from symgen.bench.ablation import Ablation, ablation
from symgen.bench.data import speed_data
from symgen.bench.measure import Settings, bench, sample_states
from symgen.bench.page import write_files
from symgen.bench.result import BenchResult, FunctionFacts, Row

__all__ = [
    "Ablation",
    "BenchResult",
    "FunctionFacts",
    "Row",
    "Settings",
    "ablation",
    "bench",
    "sample_states",
    "speed_data",
    "write_files",
]
