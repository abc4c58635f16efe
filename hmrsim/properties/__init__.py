"""Properties of runs, and a monitor that says which of them hold: live, on a trace or on a recording."""

from hmrsim.properties.model.checking import check_properties
from hmrsim.properties.model.file import Properties
from hmrsim.properties.model.reading import properties_of, read_properties
from hmrsim.properties.monitor import Monitor
from hmrsim.properties.results import Ended, Verdict, Violation
from hmrsim.properties.sink import MonitorSink

__all__ = [
    "Ended",
    "Monitor",
    "MonitorSink",
    "Properties",
    "Verdict",
    "Violation",
    "check_properties",
    "properties_of",
    "read_properties",
]
