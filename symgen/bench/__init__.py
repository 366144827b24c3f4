"""``symgen bench``: speed and error of the generated C, beside the peers that are installed."""

from symgen.bench.measure import bench
from symgen.bench.page import write_report
from symgen.bench.result import BenchResult, FunctionRow, PeerRow

__all__ = ["BenchResult", "FunctionRow", "PeerRow", "bench", "write_report"]
