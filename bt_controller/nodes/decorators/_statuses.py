"""Statuses as values of ports, named as in BehaviorTree.CPP."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from py_trees.common import Status

from bt_controller.core.ports import Kind

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.core.ports import Places

_STATUSES: Final[Mapping[str, Status]] = MappingProxyType(
    {
        "SUCCESS": Status.SUCCESS,
        "FAILURE": Status.FAILURE,
        "RUNNING": Status.RUNNING,
        "SKIPPED": Status.INVALID,
    }
)


def _status(text: str, _places: Places | None) -> Status:
    if text.strip() not in _STATUSES:
        raise ValueError(f"{text!r} is not a status; expected SUCCESS, FAILURE, RUNNING or SKIPPED")
    return _STATUSES[text.strip()]


STATUS: Final = Kind("NodeStatus", Status, _status)
