"""The events of the world: one class per event, grouped by subject, each with its text in English.

The simulation publishes events. The log, reports, traces and recordings match on their classes, and the schemas, the
tables in the docs and the texts on the page are generated from them. Other packages add events through entry points
of the group ``hmrsim.events``, each of which names a module with an `EventGroup` called ``EVENTS``.
"""

from hmrsim.events._event import Event, EventGroup, Part, Severity, model_of
from hmrsim.events._registry import STATUSES, EventPattern, UnknownEvent, flaws, from_json, groups, registry, texts

__all__ = [
    "STATUSES",
    "Event",
    "EventGroup",
    "EventPattern",
    "Part",
    "Severity",
    "UnknownEvent",
    "flaws",
    "from_json",
    "groups",
    "model_of",
    "registry",
    "texts",
]
