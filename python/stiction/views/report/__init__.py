"""Reports on results as HTML. Each report is a single file without external resources."""

from stiction.views.report.page import ReportError
from stiction.views.report.result import evaluate_report, report_page, save_report

__all__ = ["ReportError", "evaluate_report", "report_page", "save_report"]
