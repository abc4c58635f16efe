"""Robots reach all goals that are reachable by any sequence of moves, under `priority` and `planned`."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import networkx as nx
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from benchmarks._dispatched import dispatched
from benchmarks.first_fleets import fleet
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from tests.profiles import examples
from tests.simulation import simulate

SIDE = 3
STEP = 10.0
CELLS = [(x, y) for x in range(SIDE) for y in range(SIDE)]
PAIRS = [(a, b) for a in CELLS for b in CELLS if a < b and abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1]
DOORS = st.sampled_from(
    (*[None] * 5, {"open": True}, {}, {"stays_open": 0.0}, {"opening_time": 0.0}, "closed", "locked")
)


def name_of(cell):
    return f"w{cell[0]}{cell[1]}"


@dataclass(frozen=True)
class Case:
    """A connected part of a small lattice with doors, a lift, docks, one-way lanes, and robots with goals.

    Attributes:
        lanes: In each direction in which they can be driven.
        doors: By the lane that they are on; a text is what an open door is ordered to be.
        lift: Its stops, which have room for any number of robots.
    """

    lanes: nx.DiGraph
    doors: dict
    lift: tuple | None
    docks: list
    starts: list
    goals: list
    policy: str

    def ways(self):
        """Return the lanes that are not locked."""
        locked = [pair for pair, door in self.doors.items() if door == "locked"]
        return nx.restricted_view(self.lanes, [], [*locked, *((b, a) for a, b in locked)])

    def orders(self):
        for number, door in enumerate(self.doors.values()):
            if isinstance(door, str):
                yield {"name": f"door_{number}", "state": door}

    def world(self):
        lanes = [
            {"from": name_of(a), "to": name_of(b), "one_way": not self.lanes.has_edge(b, a)}
            for a, b in sorted(self.lanes.edges)
            if a < b or not self.lanes.has_edge(b, a)
        ]
        doors = [
            {"at": across(*pair), **({"open": True} if isinstance(door, str) else door)}
            for pair, door in self.doors.items()
        ]
        return {
            "waypoints": {name_of(cell): [STEP * cell[0], STEP * cell[1]] for cell in sorted(self.lanes)},
            "lanes": lanes,
            "doors": {f"door_{number}": door for number, door in enumerate(doors)},
            "lifts": {"lift": {"stops": [name_of(stop) for stop in self.lift]}} if self.lift else {},
            "docks": {f"dock_{number}": {"at": name_of(cell)} for number, cell in enumerate(self.docks)},
            "robots": {f"robot_{number}": {"at": name_of(cell)} for number, cell in enumerate(self.starts)},
            "traffic": {"policy": self.policy, "patience": None},
        }


@st.composite
def cases(draw):
    """Draw a case in which every robot could return from wherever it goes."""
    pairs = draw(st.lists(st.sampled_from(PAIRS), min_size=3, max_size=len(PAIRS), unique=True))
    ways = nx.Graph(pairs)
    ways = ways.subgraph(max(nx.connected_components(ways), key=lambda part: (len(part), sorted(part))))
    edges, cells = sorted(ways.edges), sorted(ways)
    assume(len(cells) > 2)
    lanes = nx.DiGraph(ways)
    lanes.remove_edges_from([pair for pair in edges if draw(st.integers(0, 5)) == 0])
    doors = {pair: door for pair in edges if (door := draw(DOORS)) is not None}
    apart = [pair for pair in permutations(cells, 2) if not ways.has_edge(*pair)]
    lift = draw(st.none() | st.sampled_from(apart)) if apart else None
    count = draw(st.integers(2, min(4, len(cells) - 1)))
    starts, goals = draw(st.permutations(cells))[:count], draw(st.permutations(cells))[:count]
    # A docked robot without a goal elsewhere makes no room.
    free = [cell for cell in cells if (cell, cell) not in zip(starts, goals, strict=True)]
    docks = draw(st.lists(st.sampled_from(free), max_size=2, unique=True)) if free else []
    case = Case(lanes, doors, lift, docks, starts, goals, draw(st.sampled_from(["priority", "planned"])))
    assume(nx.is_strongly_connected(case.ways()))
    return case


def across(a, b):
    """Return a door in the middle of a lane."""
    x, y = STEP * (a[0] + b[0]) / 2, STEP * (a[1] + b[1]) / 2
    return [[x - 1, y], [x + 1, y]] if a[0] == b[0] else [[x, y - 1], [x, y + 1]]


def is_solvable(case):
    """Return whether all robots can be at their goals at once, by an exhaustive search."""
    graph, roomy = case.ways(), frozenset(case.lift or ())
    steps = {cell: sorted(graph.successors(cell)) for cell in graph}
    for a, b in permutations(case.lift, 2) if case.lift else ():
        steps[a] = [*steps[a], b]
    todo, seen = [tuple(case.starts)], {tuple(case.starts)}
    while todo:
        places = todo.pop()
        if places == tuple(case.goals):
            return True
        for after in (*single_moves(places, steps, roomy), *rotations(places, steps)):
            if after not in seen:
                seen.add(after)
                todo.append(after)
    return False


def single_moves(places, steps, roomy):
    """Yield the places after one robot has driven one lane; lift stops hold several robots."""
    for i, place in enumerate(places):
        for cell in steps[place]:
            if cell in roomy or cell not in places:
                yield (*places[:i], cell, *places[i + 1 :])


def rotations(places, steps):
    """Yield the places after three or more robots of a circle have moved at once."""
    for size in range(3, len(places) + 1):
        for ring in permutations(range(len(places)), size):
            pairs = [*zip(ring, ring[1:] + ring[:1], strict=True)]
            if ring[0] == min(ring) and all(places[b] in steps[places[a]] for a, b in pairs):
                after = list(places)
                for a, b in pairs:
                    after[a] = places[b]
                yield tuple(after)


@examples(90)
@given(cases())
def test_every_solvable_case_is_solved(case):
    """No goal ends by patience, and deadlocks are dissolved."""
    assume(is_solvable(case))
    run = simulate(case.world(), topics=frozenset({Topic.EVENTS}))
    for order in case.orders():
        run.ask("set_door_state", order)
    for number, (x, y) in enumerate(case.goals):
        pose = PoseStamped(pose=Pose(position=Point(x=STEP * x, y=STEP * y)))
        run.simulator.submit(SendGoal(f"robot_{number}", "navigate_to_pose", NavigateToPose.Goal(pose=pose)))
    run.simulator.run(until=5_000.0)
    ends = [event.status for _, event in run.log.events if isinstance(event, GoalChanged) and event.status.terminal]

    assert [GoalStatus.SUCCEEDED] * len(case.goals) == ends, told(run)


def told(run):
    """Return the history, for the message of a failure."""
    return "\n".join(
        f"{at:.1f} {output.event.describe()}"
        for at, output in run.log.events
        if isinstance(output, EventStamped) and output.event.kind not in ("motion", "route", "goal")
    )


SEEDS = (6, 7, 10, 13, 22, 34, 45, 53, 57, 58, 66, 72, 80, 255, 371, 933, 957)
"""Fleets whose orders can all be served, each of which once showed a mistake of the policies."""


@pytest.mark.parametrize("policy", ["priority", "planned"])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_plain_dispatcher_serves_every_order(seed, policy):
    outcome = dispatched(fleet(seed, policy))

    assert (outcome.total, [], []) == (outcome.served, outcome.touching, outcome.waiting)


@pytest.mark.parametrize("seed", SEEDS[:4])
def test_a_robot_that_is_given_up_names_the_last_cause_and_what_would_help(seed):
    """Under `reserve`, robots make no room."""
    outcome = dispatched(fleet(seed, "reserve"))
    blocked = [text for text in outcome.aborted if "blocked for" in text]

    assert blocked
    assert all(" since " in text and " is idle at " in text and "; what would help: " in text for text in blocked)
