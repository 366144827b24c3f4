"""HTML reports: one self-contained page per scene, and an index of them."""

from symgen.report.index import write_index
from symgen.report.page import IndexEntry, write_report

__all__ = ["IndexEntry", "write_index", "write_report"]
