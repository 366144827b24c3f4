"""HTML reports: one self-contained page per scene, and an index of them."""

from symgen.report.index import write_index
from symgen.report.page import IndexEntry, write_report
from symgen.report.picture import write_drawing

__all__ = ["IndexEntry", "write_drawing", "write_index", "write_report"]
