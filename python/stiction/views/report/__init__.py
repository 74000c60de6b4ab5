"""One page of results for a browser: `save_report` writes it, `report_page` returns it."""

from stiction.views.report.page import ReportError
from stiction.views.report.results import report_page, save_report

__all__ = ["ReportError", "report_page", "save_report"]
