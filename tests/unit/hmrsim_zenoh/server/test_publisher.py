"""The rate limit of feedback, which never drops a goal's last one."""

from __future__ import annotations

import pytest

from hmrsim.protocol.outputs import FeedbackSent
from hmrsim_zenoh.server import publisher
from hmrsim_zenoh.server.publisher import FeedbackLimiter


@pytest.fixture
def passed(monkeypatch: pytest.MonkeyPatch) -> object:
    """Return a function that returns which of (wall time, goal, whether it is the last) pass."""

    def play(*sent: tuple[float, str, bool]) -> list[bool]:
        thinned, found = FeedbackLimiter(), []
        for time, goal_id, last in sent:
            monkeypatch.setattr(publisher.time, "monotonic", lambda time=time: time)
            found.append(thinned.passes(FeedbackSent("wall_e", "wait", goal_id, {}, last)))
        return found

    return play


def test_twenty_a_wall_second(passed):
    """Feedback within a twentieth of a wall second after the last that passed is dropped."""
    assert [True, False, False, True] == passed(
        (1.0, "a", False), (1.02, "a", False), (1.04, "a", False), (1.06, "a", False)
    )


def test_many_goals_share_a_limit(passed):
    """With 1,000 goals, each one's feedback passes twice per wall second, so that all have 2,000 messages together."""
    first = [(1.0, f"{goal}", False) for goal in range(1000)]
    assert [True] * 1000 + [False, True] == passed(*first, (1.49, "7", False), (1.51, "7", False))


def test_last(passed):
    """The last feedback of a goal passes at any time."""
    assert [True, True] == passed((1.0, "a", False), (1.01, "a", True))


def test_goals_are_thinned_apart(passed):
    """The feedback rate of one goal does not affect another's."""
    assert [True, True] == passed((1.0, "a", False), (1.01, "b", False))
