"""A status list assembled from cached entries equals the codec's."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.interfaces.action_msgs import GoalStatusArray
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.protocol.goal import GoalEntry, GoalStatus, made_goal_id
from hmrsim_zenoh.ros2.codec.types import message_type
from hmrsim_zenoh.ros2.publishing.goal_topics import Statuses

TYPE = message_type(GoalStatusArray)
GOALS = [made_goal_id("test", number) for number in range(6)]


def plain(goals: list[GoalEntry]) -> dict[str, object]:
    """Return a status list as plain values."""
    infos = [{"goal_id": {"uuid": list(bytes.fromhex(one.goal_id))}, "stamp": values_of(one.stamp)} for one in goals]
    return {"status_list": [{"goal_info": i, "status": int(one.status)} for i, one in zip(infos, goals, strict=True)]}


def test_two_goals() -> None:
    """The second entry is padded, the first is not."""
    first = GoalEntry("00" * 15 + "01", 2_000_000_003, GoalStatus.SUCCEEDED)
    second = GoalEntry("00" * 15 + "04", 5_000_000_006, GoalStatus.EXECUTING)

    expected = (
        "00010000" "02000000"
        "00000000000000000000000000000001" "02000000" "03000000" "04"
        "00000000000000000000000000000004" "000000" "05000000" "06000000" "02"
    )  # fmt: skip
    assert expected == Statuses().encode((first, second)).hex()


# The goals that are listed, and the status of each: goals come, change, and go from anywhere.
LISTS = st.lists(st.dictionaries(st.sampled_from(range(6)), st.sampled_from(list(GoalStatus))), max_size=8)


@given(LISTS)
def test_any_sequence_of_lists(lists: list[dict[int, GoalStatus]]) -> None:
    """The encoding of a list does not depend on earlier lists."""
    statuses = Statuses()
    for listed in lists:
        goals = [GoalEntry(GOALS[number], 10**9 * number + 7, status) for number, status in sorted(listed.items())]

        assert TYPE.encode(plain(goals)) == statuses.encode(goals)
