"""Properties of runs, and a monitor that judges them: live, on a trace or on a recording."""

from hmrsim.properties.model.checks import check_properties
from hmrsim.properties.model.file import Properties, properties_of, read_properties
from hmrsim.properties.monitor import Monitor, MonitorSink
from hmrsim.properties.offline import Checked, check_recording, check_trace
from hmrsim.properties.results import Ended, Verdict, Violation

__all__ = [
    "Checked",
    "Ended",
    "Monitor",
    "MonitorSink",
    "Properties",
    "Verdict",
    "Violation",
    "check_properties",
    "check_recording",
    "check_trace",
    "properties_of",
    "read_properties",
]
