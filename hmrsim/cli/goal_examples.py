"""An example of a goal, with the places, docks and items of the world that runs."""

from __future__ import annotations

import json
from contextlib import suppress
from itertools import chain
from typing import TYPE_CHECKING, Any

from hmrsim.errors import HmrsimError
from hmrsim_zenoh.client.places import with_names

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.actions import AnyAction
    from hmrsim_zenoh.client.client import Client


def example_of(client: Client, action: AnyAction, robot: str) -> Mapping[str, Any] | None:
    """Return an example of a goal in plain values; with names that are no world's if the simulator does not tell any.

    Returns:
        None for an action that has no example.
    """
    if not action.example:
        return action.example
    with suppress(HmrsimError):
        places, choices = _names_in(client, robot)
        example: dict[str, Any] = with_names(dict(action.example), action.goal, iter(places))
        for field, given in (action.inputs or {}).items():
            if field in example and (there := choices.get(given.choices)):
                example[field] = there[0]
        return example
    return action.example


def _names_in(client: Client, robot: str) -> tuple[list[str], dict[str, list[str]]]:
    """Return the names of places to drive to, and those of a field's choices, see `hmrsim.actions._inputs.Input`."""
    scene = json.loads(client.get(client.keys.world("scene")))
    docks = [one["name"] for one in scene["fixtures"] if one["kind"] == "dock"]
    items = [one["name"] for one in scene["items"]]
    held = [one["name"] for one in scene["items"] if one["carrier"] == robot]
    places = [name for name in client.places.load() if name not in docks]
    return places, {"docks": docks, "items": items, "held": list(chain(held, items))}
