"""A run as one page that replays it: map, goals, trees and events over time, beside a run that differs from it."""

from hmrsim.run_page.comparison import Cause, Heading, ShownRun
from hmrsim.run_page.run_log import RunLog
from hmrsim.run_page.writer import page_of

__all__ = ["Cause", "Heading", "RunLog", "ShownRun", "page_of"]
