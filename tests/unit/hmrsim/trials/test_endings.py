"""The endings of controllers in the process of their run."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest

from hmrsim.interfaces.nav2_msgs import Spin
from hmrsim.trials.trial import TimeLimit, control
from hmrsim_zenoh.errors import GoalRejectedError, SimulationEnded

if TYPE_CHECKING:
    from collections.abc import Callable

WORLD: Any = SimpleNamespace(robots={})
CLIENT: Any = None

REJECTED = GoalRejectedError("not_ready", 0, "eve has broken down")


def raises(error: BaseException) -> Callable[..., Any]:
    def controller(*_: object) -> bool:
        raise error

    return controller


def raises_in_a_task(error: BaseException) -> Callable[..., Any]:
    """Return a controller in which a task of a task group raises an error."""

    async def task() -> None:
        raise error

    async def tasks() -> None:
        async with asyncio.TaskGroup() as group:
            group.create_task(task())

    return lambda *_: asyncio.run(tasks())


@pytest.mark.parametrize("controller", [raises, raises_in_a_task])
@pytest.mark.parametrize(
    ("error", "ending", "cause"),
    [
        (SimulationEnded("the run is over"), "failed", ""),
        (TimeLimit("too long"), "hung", "too long"),
        (MemoryError(), "out_of_memory", "it takes more memory than its limit"),
    ],
)
def test_error_is_the_ending(controller: Callable[..., Any], error: BaseException, ending: str, cause: str) -> None:
    """An error in an exception group counts as well."""
    assert (ending, cause) == control(controller(error), CLIENT, WORLD)


@pytest.mark.parametrize("controller", [raises, raises_in_a_task])
def test_failed_goal_has_its_place(controller: Callable[..., Any]) -> None:
    ending, cause = control(controller(REJECTED), CLIENT, WORLD)

    assert "crashed" == ending
    assert cause.startswith("GoalRejectedError: not_ready: eve has broken down (")
    assert "test_endings.py:" in cause


def test_invalid_message_has_its_fields() -> None:
    def controller(*_: object) -> bool:
        return bool(Spin.Goal.model_validate({"target_yaw": "left", "yaw": 1}))

    _, cause = control(controller, CLIENT, WORLD)

    fields = "target_yaw: input should be a valid number, got 'left'; yaw: extra inputs are not permitted, got 1"
    assert cause.startswith(f"ValidationError: Goal: {fields} (")
    assert "test_endings.py:" in cause


@pytest.mark.parametrize("controller", [raises, raises_in_a_task])
def test_bug_has_its_place_in_the_controller(controller: Callable[..., Any]) -> None:
    ending, cause = control(controller(KeyError("eve")), CLIENT, WORLD)

    assert "crashed" == ending
    assert cause.startswith("KeyError: 'eve' (")
    assert "test_endings.py:" in cause


def test_place_is_in_the_users_code() -> None:
    """A library that raises the error is skipped."""
    ending, cause = control(lambda *_: json.loads("{"), CLIENT, WORLD)

    assert "crashed" == ending
    assert "test_endings.py:" in cause
