"""The report of a run: one HTML page that needs nothing else."""

from stretch_bt.runtime.report.page import write_report

__all__ = ["write_report"]
