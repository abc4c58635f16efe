"""JSON Schemas of the recording's own channels, which have the payloads of the keys of the same names."""

from __future__ import annotations

import json
from typing import Any, Final

from hmrsim.world_checks.schema import world_schema
from hmrsim_zenoh.recording.writing import Schema
from hmrsim_zenoh.wire.tree_state import TreeState

_STAMP: Final = {
    "type": "object",
    "properties": {"sec": {"type": "integer"}, "nanosec": {"type": "integer"}},
    "description": "Simulated time.",
}
_TEXT: Final = {"type": "string"}


def _object(*lists: str, **properties: Any) -> dict[str, Any]:
    """Return the schema of an object with these properties and these lists of objects; others are allowed."""
    listed = {name: {"type": "array", "items": {"type": "object"}} for name in lists}
    return {"type": "object", "properties": {**properties, **listed}}


def json_schema(name: str, schema: dict[str, Any]) -> Schema:
    """Return the schema of a JSON channel."""
    return Schema(name, "jsonschema", json.dumps(schema), "json")


EVENT: Final = json_schema("hmrsim/Event", _object(stamp=_STAMP, kind=_TEXT, robot=_TEXT))
SCENE: Final = json_schema(
    "hmrsim/Scene", _object("robots", "items", "fixtures", "closed_lanes", "faults", stamp=_STAMP)
)
INFO: Final = json_schema(
    "hmrsim/WorldInfo", _object("robots", "services", contract={"type": "integer"}, world=_object(name=_TEXT))
)


def world() -> Schema:
    """Return the schema of worlds."""
    return json_schema("hmrsim/World", world_schema())


def tree() -> Schema:
    """Return the schema of the tree states that controllers publish."""
    return json_schema("hmrsim/Tree", TreeState.model_json_schema(mode="serialization"))
