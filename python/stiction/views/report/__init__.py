"""A page for a browser of a result, which needs nothing else."""

from stiction.views.report.page import ReportError
from stiction.views.report.result import report_page, save_report

__all__ = ["ReportError", "report_page", "save_report"]
