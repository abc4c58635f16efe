"""Reports on runs: from a trace or a recording, as a page, as JSON or as tables.

The command `hmrsim report` uses it.
"""

from hmrsim.report.compile import ReportInput, report_of, section_of
from hmrsim.report.model import Report, Section, Sections
from hmrsim.report.reading import of_recording, of_trace

__all__ = ["Report", "ReportInput", "Section", "Sections", "of_recording", "of_trace", "report_of", "section_of"]
