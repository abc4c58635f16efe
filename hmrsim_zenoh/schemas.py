"""Writes ``schemas/``: JSON Schema of worlds, settings, properties, events, actions, services, envelopes and reports.

Run as ``python -m hmrsim_zenoh.schemas [--check] [DIRECTORY]``; the files are generated and never edited.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from hmrsim.actions import registry
from hmrsim.events import flaws, model_of
from hmrsim.events import registry as events
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.properties import Properties
from hmrsim.report.model import Report, Sections
from hmrsim.services import registry as services
from hmrsim.world_checks.schema import world_schema
from hmrsim_zenoh.server import decode_time
from hmrsim_zenoh.settings import settings_schema
from hmrsim_zenoh.wire import envelopes
from hmrsim_zenoh.wire.descriptions import TreeState

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.events import Event
    from hmrsim.services import Service

_DIALECT = "https://json-schema.org/draft/2020-12/schema"


_Parts = Mapping[str, tuple[type[BaseModel], JsonSchemaMode]]


def _together(title: str, parts: _Parts, **more: str) -> dict[str, Any]:
    """Return one schema of several messages, each below its name."""
    references, schema = models_json_schema([*parts.values()])
    properties = {name: references[part] for name, part in parts.items()}
    return {"$schema": _DIALECT, "title": title, **more, "type": "object", "properties": properties, **schema}


def action_schema(action: AnyAction) -> dict[str, Any]:
    """Return the schema of all messages of an action, by the last chunk of the key that they travel on."""
    parts: _Parts = {
        "send_goal": (envelopes.SendGoalRequest[action.goal], "validation"),  # type: ignore[name-defined]  # a type at run time
        "execute": (envelopes.ExecuteRequest[action.goal], "validation"),  # type: ignore[name-defined]
        "get_result": (envelopes.GetResultResponse[action.result], "serialization"),  # type: ignore[name-defined]
        "feedback": (envelopes.FeedbackMessage[action.feedback], "serialization"),  # type: ignore[name-defined]
    }
    what = "send_goal, execute: the requests; get_result: the reply, as the last one of execute; feedback: the message."
    return _together(f"{action.name} ({action.ros_type})", parts, description=what)


def _service_schema(service: Service) -> dict[str, Any]:
    """Return the schema of a service's request and reply."""
    parts: _Parts = {"request": (service.request, "validation"), "reply": (service.response, "serialization")}
    return _together(f"{service.name} ({service.ros_type})", parts)


def _envelope_schema() -> dict[str, Any]:
    """Return the schema of the messages that all actions share."""
    parts: _Parts = {
        "send_goal_reply": (envelopes.SendGoalResponse, "serialization"),
        "cancel_goal": (envelopes.CancelGoalRequest, "validation"),
        "cancel_goal_reply": (envelopes.CancelGoalResponse, "serialization"),
        "get_result": (envelopes.GetResultRequest, "validation"),
        "status": (envelopes.GoalStatusArray, "serialization"),
    }
    return _together("Messages of all actions", parts)


def _time_schema() -> dict[str, Any]:
    """Return the schema of the requests about time, by the last chunk of their keys."""
    parts: _Parts = {
        "join": (decode_time.JoinRequest, "validation"),
        "advance": (decode_time.AdvanceRequest, "validation"),
        "leave": (decode_time.LeaveRequest, "validation"),
        "set": (decode_time.SetRequest, "validation"),
    }
    return _together("Requests below _world/time", parts)


def _schema(model: type[BaseModel], **options: Any) -> dict[str, Any]:
    return {"$schema": _DIALECT, **model.model_json_schema(**options)}


def event_schema() -> dict[str, Any]:
    """Return the schema of the messages on ``_world/events``; kinds that are not in it may have any fields."""
    definitions, cases = {}, []
    for kind, event in events().items():
        definitions[event.__name__] = _fields_schema(event)
        condition = {"properties": {"kind": {"const": kind}}}
        cases.append({"if": condition, "then": {"$ref": f"#/$defs/{event.__name__}"}})
    stamp = {"description": "When, in simulated time.", **Time.model_json_schema()}
    properties = {"stamp": stamp, "kind": {"type": "string", "description": "What happened.", "examples": [*events()]}}
    head = {"$schema": _DIALECT, "title": "Events", "type": "object"}
    return {**head, "required": ["stamp", "kind"], "properties": properties, "allOf": cases, "$defs": definitions}


def _fields_schema(event: type[Event]) -> dict[str, Any]:
    """Return the schema of an event's fields, without titles, which would repeat the names."""
    schema = model_of(event).model_json_schema(by_alias=True)
    if event.rest:
        del schema["properties"][event.rest]
        schema["required"].remove(event.rest)
    for field in schema.get("properties", {}).values():
        field.pop("title", None)
        if field.get("default") is None:
            field.pop("default", None)
    return {"description": schema.pop("description"), **schema}


def _all_schemas() -> dict[str, dict[str, Any]]:
    """Return every schema by the name of its file below ``schemas/``."""
    actions = {f"actions/{name}.schema.json": action_schema(action) for name, action in registry().items()}
    asked = {f"services/{name}.schema.json": _service_schema(service) for name, service in services().items()}
    shared = {
        "envelopes.schema.json": _envelope_schema(),
        "time.schema.json": _time_schema(),
        "tree.schema.json": _schema(TreeState, mode="serialization"),
        "report.schema.json": _schema(Report, mode="serialization"),
        "report_sections.schema.json": _schema(Sections, mode="serialization"),
        "properties.schema.json": _schema(Properties, by_alias=True),
        "events.schema.json": event_schema(),
        "settings.schema.json": {"$schema": _DIALECT, **settings_schema()},
    }
    return {"world.schema.json": world_schema(), **shared, **actions, **asked}


def main(argv: Sequence[str] | None = None) -> int:
    """Write the schemas, or say which are out of date."""
    parser = argparse.ArgumentParser(prog="python -m hmrsim_zenoh.schemas", description=main.__doc__)
    parser.add_argument("directory", nargs="?", type=Path, default=Path("schemas"))
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file is out of date")
    arguments = parser.parse_args(argv)
    stale = 0
    for flaw in flaws():
        sys.stderr.write(f"{flaw}\n")
        stale += 1
    for name, schema in _all_schemas().items():
        path = arguments.directory / name
        text = json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        if arguments.check:
            sys.stderr.write(f"{path}: out of date; run make schemas\n")
            stale += 1
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
