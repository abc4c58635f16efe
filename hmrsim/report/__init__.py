"""Reports on runs: from a trace or a recording, as a page, as JSON or as tables.

The command `hmrsim report` uses it.
"""

from hmrsim.report.compile import report_of
from hmrsim.report.model import Report
from hmrsim.report.reading import ReportInput, of_recording, of_trace

__all__ = ["Report", "ReportInput", "of_recording", "of_trace", "report_of"]
