"""Poses by name: a goal in plain values may have the name of a place wherever its message has a pose."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, get_args

from hmrsim.diagnostics import dotted
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.diagnostics import Path


def with_poses(data: Any, kind: type[BaseModel], pose: Callable[[str], PoseStamped]) -> Any:
    """Return the plain values of a goal with a pose for each name of a place.

    Args:
        data: The goal, which need not be valid.
        kind: Its message type.
        pose: Returns the pose of a place; raises `ValueError` for an unknown name.

    Raises:
        ValueError: There is no such place; one line per error.
    """
    mistakes: list[str] = []

    def named(value: Any, field: type[BaseModel], path: Path) -> Any:
        if not isinstance(value, str):
            return value
        try:
            stamped = pose(value)
        except ValueError as error:
            mistakes.append(f"goal: {dotted(path)}: {error}")
            return value
        return (stamped if field is PoseStamped else stamped.pose).model_dump(mode="json")

    found = _map_poses(data, kind, named)
    if mistakes:
        raise ValueError("\n".join(mistakes))
    return found


def with_names(data: Any, kind: type[BaseModel], names: Iterator[str]) -> Any:
    """Return the plain values of a goal with the next of some *names* for each of its poses."""
    return _map_poses(data, kind, lambda value, _kind, _path: next(names, value))


def _map_poses(data: Any, kind: Any, change: Callable[[Any, type[BaseModel], Path], Any], path: Path = ()) -> Any:
    if kind in (Pose, PoseStamped):
        return change(data, kind, path)
    fields = getattr(kind, "model_fields", None)
    if fields is not None and isinstance(data, Mapping):
        return {
            name: _map_poses(value, fields[name].annotation, change, (*path, name)) if name in fields else value
            for name, value in data.items()
        }
    if isinstance(data, list) and (of := get_args(kind)):
        return [_map_poses(value, of[0], change, (*path, at)) for at, value in enumerate(data)]
    return data
