"""What a client knows of its goal."""

from __future__ import annotations

from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.goal_handle import GoalHandle


class Handle(GoalHandle):
    """A goal that nobody can cancel."""


for _name in Handle.__abstractmethods__:
    setattr(Handle, _name, lambda *_args: None)
Handle.__abstractmethods__ = frozenset()


def test_a_goal_is_accepted_once():
    """A second answer, to a request that was repeated, changes nothing and is told to nobody."""
    changes = []
    handle = Handle("eve/wait", "a" * 32, on_feedback=None, on_change=lambda goal: changes.append(goal.status))

    assert (True, False) == (handle._accept(GoalStatus.EXECUTING), handle._accept(GoalStatus.EXECUTING))
    assert handle.accepted
    assert 1 == len(changes)
