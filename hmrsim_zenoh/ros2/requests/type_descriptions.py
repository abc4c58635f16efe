"""The service of each node that describes the types of its endpoints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.type_description_interfaces import GetTypeDescription

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.codec.types import MessageType, ServiceType


def describe(types: Iterable[MessageType | ServiceType], request: Mapping[str, Any]) -> dict[str, Any]:
    """Return the description of one of the types, which the request selects by its hash, as rcl does.

    It has no defaults of fields, and the response has no sources: the types derive from our models.
    """
    response = GetTypeDescription.Response
    found = next((one for one in types if one.hash == request["type_hash"]), None)
    if found is None:
        return unbuilt(response, failure_reason="Type not currently in use by this node")
    whole = found.structure.describe()
    described = {
        "type_description": _without_defaults(whole["type_description"]),
        "referenced_type_descriptions": list(map(_without_defaults, whole["referenced_type_descriptions"])),
    }
    return unbuilt(response, successful=True, type_description=described)


def _without_defaults(described: Mapping[str, Any]) -> dict[str, Any]:
    return {**described, "fields": [{**field, "default_value": ""} for field in described["fields"]]}
