"""The first causes of the waits of a run."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.history.robots import STATES
from hmrsim.report.first_causes import FirstCause, first_causes
from hmrsim.report.goals import WaitRecord
from hmrsim.report.robots import Track
from tests.profiles import examples

NAMES = ("ann", "bob", "cid", "dan")


def track(name, spans=(), waits=()):
    return Track(name, "cart", 0, spans=[*spans], stood=[*waits])


def waits(robot, began, ended, *robots, **fields):
    return WaitRecord(robot, began, fields.pop("kind", "way"), robots, ended=ended, **fields)


def causes(*tracks):
    """Return the first causes of tracks, each with the time of each robot."""
    return {cause: dict(times) for cause, times in first_causes({each.name: each for each in tracks}).items()}


def test_a_chain_leads_to_the_robot_that_does_not_wait():
    """Bob works until 8, and is idle from then on."""
    ann = track("ann", [(0, 10, "waiting")], [waits("ann", 2, 10, "cid")])
    cid = track("cid", [(0, 10, "waiting")], [waits("cid", 0, 10, "bob")])
    bob = track("bob", [(0, 8, "busy"), (8, 10, "idle")])

    assert {
        FirstCause("bob", "busy"): {"ann": 6, "cid": 8},
        FirstCause("bob", "idle"): {"ann": 2, "cid": 2},
    } == causes(ann, cid, bob)


def test_a_robot_that_drives_on_counts_only_where_all_do():
    ann = track("ann", [(0, 10, "waiting")], [waits("ann", 0, 10, "bob", "cid")])
    bob = track("bob", [(0, 10, "driving")])
    cid = track("cid", [(0, 6, "charging"), (6, 10, "driving")])

    assert {FirstCause("cid", "charging"): {"ann": 6}, FirstCause("bob", "driving"): {"ann": 4}} == causes(
        ann, bob, cid
    )


def test_obstacles_queues_and_turns_end_a_chain():
    found = causes(
        track("ann", (), [waits("ann", 0, 1, "bob")]),
        track("bob", (), [waits("bob", 0, 1, why="gate is opening")]),
        track("cid", (), [waits("cid", 0, 2, why="charger", kind="dock")]),
        track("dan", (), [waits("dan", 0, 3)]),
    )

    gate = {FirstCause("gate is opening", "obstacle"): {"ann": 1, "bob": 1}}
    assert gate | {FirstCause("charger", "queue"): {"cid": 2}, FirstCause("its turn", "turn"): {"dan": 3}} == found


def test_robots_that_wait_for_each_other_are_a_circle():
    """Also for a robot that waits behind them."""
    ann = track("ann", (), [waits("ann", 0, 5, "bob")])
    bob, cid = track("bob", (), [waits("bob", 0, 5, "cid")]), track("cid", (), [waits("cid", 0, 5, "bob")])

    assert {FirstCause("bob, cid", "circle"): {"ann": 5, "bob": 5, "cid": 5}} == causes(ann, bob, cid)


def test_a_long_jam():
    names = [f"r{number:04}" for number in range(2_000)]
    jam = [track(name, (), [waits(name, 0, 9, following)]) for name, following in pairwise(names)]

    assert 9 * 1_999 == sum(sum(times.values()) for times in causes(*jam, track(names[-1])).values())


@st.composite
def tracks(draw, name):
    """Return a robot with any states, and waits that do not overlap."""
    times = sorted(draw(st.sets(st.integers(0, 100), max_size=8)))
    spans = [(*pair, draw(st.sampled_from(STATES))) for pair in pairwise(times)]
    stood = []
    for began, ended in pairwise(sorted(draw(st.sets(st.integers(0, 100), max_size=8)))):
        others = draw(st.lists(st.sampled_from(NAMES), unique=True, max_size=3))
        stood.append(waits(name, began, ended, *(other for other in others if other != name)))
    return track(name, spans, stood)


@examples(300)
@given(data=st.data())
def test_each_wait_is_attributed_as_a_whole(data):
    """Exactly, in nanoseconds, whatever the robots in the way do."""
    found = [data.draw(tracks(name)) for name in NAMES]
    waited = {each.name: sum(wait.length for wait in each.stood) for each in found}

    told = dict.fromkeys(NAMES, 0)
    for times in causes(*found).values():
        for name, time in times.items():
            assert time > 0
            told[name] += time
    assert waited == told
