"""The client's handle of a goal."""

from __future__ import annotations

from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.goal_handle import GoalHandle


class Handle(GoalHandle):
    """A goal handle without a connection."""


for _name in Handle.__abstractmethods__:
    setattr(Handle, _name, lambda *_args: None)
Handle.__abstractmethods__ = frozenset()


def test_a_goal_is_accepted_once():
    """A second answer, to a repeated request, changes nothing and runs no callback."""
    changes = []
    handle = Handle("eve/wait", "a" * 32, on_feedback=None, on_change=lambda goal: changes.append(goal.status))

    assert (True, False) == (handle._accept(GoalStatus.EXECUTING), handle._accept(GoalStatus.EXECUTING))
    assert handle.accepted
    assert 1 == len(changes)
