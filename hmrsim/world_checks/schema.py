"""The JSON Schema of native world files, for editors."""

from __future__ import annotations

import inspect
import re
from typing import TYPE_CHECKING, Any

from hmrsim import distributions
from hmrsim import faults as kinds_of_faults
from hmrsim.components import registry as components
from hmrsim.faults import registry as faults
from hmrsim.traffic.policies import registry as policies
from hmrsim.world import model
from hmrsim.world.model import DEFAULT_POLICY, World

if TYPE_CHECKING:
    from pydantic import BaseModel

_ATTRIBUTE = re.compile(r"^    (\w+): (.*(?:\n        .*)*)", re.MULTILINE)

_LANE_PAIR = {
    "type": "array",
    "description": "The two waypoints that the lane connects.",
    "items": {"type": "string"},
    "minItems": 2,
    "maxItems": 2,
}

_NONE = {"type": "null", "description": "Removes the component of the robot's type."}


def world_schema() -> dict[str, Any]:
    """Return the JSON Schema of native world files, with the settings of all components and faults."""
    schema = World.model_json_schema(by_alias=True)
    definitions: dict[str, Any] = schema["$defs"]
    for name, definition in definitions.items():
        _describe(definition, _model(name, model))
    _describe(schema, World)
    definitions["Lane"] = {"anyOf": [_LANE_PAIR, definitions["Lane"]]}
    settings = {name: _settings(component.settings, definitions) for name, component in components().items()}
    definitions["RobotType"]["properties"]["components"] = _one_of_each(settings)
    definitions["RobotSpec"]["properties"]["components"] = _one_of_each(
        {name: {"description": part["description"], "anyOf": [part, _NONE]} for name, part in settings.items()}
    )
    rules = {name: _settings(policy.settings, definitions) for name, policy in policies().items()}
    schema["properties"]["traffic"]["default"] = {}
    definitions["Traffic"] = {"anyOf": [_policy(name, part) for name, part in rules.items()]}
    kinds = {name: _settings(fault.settings, definitions) for name, fault in faults().items()}
    definitions["FaultEntry"] = {"anyOf": [_fault(name, part) for name, part in kinds.items()]}
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": "urn:hmrsim:schema:world"}
    return {**head, **schema, "title": "hmrsim world"}


def _policy(name: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of the settings of one traffic policy, identified by its name.

    The name may be left out for the policies that a world can get by default.
    """
    by_default = name in (DEFAULT_POLICY, "free")
    text = "The traffic policy; the world's robots decide if it is left out." if by_default else "The traffic policy."
    kind = {"policy": {"const": name, "description": text}}
    return {**settings, "properties": {**settings["properties"], **kind}, "required": [] if by_default else ["policy"]}


def _fault(name: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of one kind of fault, identified by its type."""
    kind = {"type": {"const": name, "description": "The type of the fault."}}
    required = ["type", *settings.get("required", ())]
    return {**settings, "properties": {**kind, **settings["properties"]}, "required": required}


def _one_of_each(settings: dict[str, Any]) -> dict[str, Any]:
    text = "The components with their settings, by name."
    return {"type": "object", "description": text, "default": {}, "properties": settings, "additionalProperties": False}


def _settings(kind: type[BaseModel], definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of the settings of a component or a fault, and add its parts to the *definitions*."""
    schema = kind.model_json_schema(by_alias=True)
    for name, part in schema.pop("$defs", {}).items():
        if name not in definitions:
            _describe(part, _model(name, inspect.getmodule(kind)))
            definitions[name] = part
    _describe(schema, kind)
    return schema


def _model(name: str, module: object) -> type[BaseModel]:
    """Return the model of a definition: a distribution, a base of faults, or one of a module."""
    places = (distributions, kinds_of_faults, module)
    found: type[BaseModel] = next(getattr(place, name) for place in places if hasattr(place, name))
    return found


def _describe(schema: dict[str, Any], kind: type[BaseModel]) -> None:
    """Take the descriptions of a model and its fields from its docstring, and drop pydantic's titles."""
    text = inspect.getdoc(kind) or ""
    texts = [inspect.cleandoc(each.__doc__ or "") for each in reversed(kind.__mro__)]
    attributes = {name: " ".join(words.split()) for text in texts for name, words in _ATTRIBUTE.findall(text)}
    schema.pop("title", None)
    schema["description"] = " ".join(text.partition("\n\nAttributes:")[0].split())
    for name, field in kind.model_fields.items() if "properties" in schema else ():
        part = schema["properties"][field.alias or name]
        part.pop("title", None)
        if name in attributes:
            part.setdefault("description", attributes[name])
