"""The report of an experiment: what its results say, as values and as one page."""

from __future__ import annotations

from hmrsim.experiments.report.model import Summary
from hmrsim.experiments.report.page import page_of
from hmrsim.experiments.report.summary import summary_of

__all__ = ["Summary", "page_of", "summary_of"]
