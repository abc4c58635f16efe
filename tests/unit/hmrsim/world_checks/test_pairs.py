"""The limit of worlds from clients, by the pairs of parts that checks compare."""

from __future__ import annotations

from typing import Any

import pytest

from hmrsim.traffic import nearness
from hmrsim.traffic.nearness import comparisons, near_slots
from hmrsim.world_checks import load_world
from hmrsim.world_checks.loading import validate, world_of
from hmrsim.world_checks.pairs import MAX_PAIRS, check_pairs

N = 3_000
TYPE = {"robot_types": {"t": {"base": {"radius": 0.1}}}}
LINE = {"waypoints": {"a": [0, 0], "b": [10, 0]}, "lanes": [["a", "b"]]}


def _robots(at: Any = lambda i: [i, 3]) -> dict[str, Any]:
    return {f"r{i}": {"at": at(i), "type": "t"} for i in range(N)}


def _rungs(count: int) -> dict[str, Any]:
    ends = {f"a{i}": [0, i] for i in range(count)} | {f"b{i}": [10, i] for i in range(count)}
    return {"waypoints": ends, "lanes": [[f"a{i}", f"b{i}"] for i in range(count)]}


def _star(count: int) -> dict[str, Any]:
    ends = {f"w{i}": [i, 0] for i in range(count)}
    return {"waypoints": ends, "lanes": [["w0", f"w{i}"] for i in range(1, count)]}


TOO_LARGE: dict[str, dict[str, Any]] = {
    "robots with walls": LINE | TYPE | {"robots": _robots(), "walls": [[[i, 1], [i + 1, 1]] for i in range(N)]},
    "robots with docks": LINE | TYPE | {"robots": _robots(), "docks": {f"d{i}": {"at": "a"} for i in range(N)}},
    "robots with doors": LINE
    | TYPE
    | {"robots": _robots(), "doors": {f"d{i}": {"at": [[5, -1], [5, 1]]} for i in range(N)}},
    "doors with lanes": _rungs(N) | {"doors": {f"d{i}": {"at": [[5, -1], [5, N]]} for i in range(N)}},
    "docks beside lanes with lanes": _rungs(N) | {"docks": {f"d{i}": {"at": [11, i]} for i in range(N)}},
    "robots with settings of their types": LINE
    | {
        "robot_types": {"t": {"components": {"battery": {"drain": {"actions": dict.fromkeys(map(str, range(N)), 1)}}}}},
        "robots": _robots(),
    },
    "starts of robots with each other": LINE
    | TYPE
    | {"robots": _robots(lambda i: [0, i]), "traffic": {"policy": "reserve"}},
    "robots beside lanes with these and with lanes": LINE
    | {"robots": {f"r{i}": {"at": [3 * i, 1]} for i in range(N)}, "traffic": {"policy": "planned"}},
    "lanes and waypoints with each other": _star(2 * N) | {"traffic": {"policy": "planned"}},
    "robots in obstacles with lanes": _star(N)
    | TYPE
    | {"robots": _robots(), "walls": [{"solid": [[-1, 1], [N, 1], [N, 9], [-1, 9]]}], "traffic": {"policy": "free"}},
    "walls with lanes that docks may not see": _rungs(200)
    | {"walls": [[[10.5, -1], [10.5, 200]]] * 200, "docks": {f"d{i}": {"at": [11, i]} for i in range(200)}},
}


def _errors(data: dict[str, Any]) -> list[str]:
    world = validate(data).value
    assert world is not None
    return [finding.message for finding in check_pairs(world)]


@pytest.mark.parametrize("most", TOO_LARGE)
def test_a_world_of_too_many_pairs_is_an_error(most):
    (message,) = _errors(TOO_LARGE[most])

    assert f"of them {most}, and the limit is {MAX_PAIRS:,}; start a simulator with it as a file" in message


def _lattice(side: int, robots: int) -> dict[str, Any]:
    points = {f"w{x}_{y}": [2 * x, 2 * y] for x in range(side) for y in range(side)}
    beside = [
        (f"w{x}_{y}", f"w{x + dx}_{y + dy}") for x in range(side) for y in range(side) for dx, dy in ((1, 0), (0, 1))
    ]
    pairs = [(a, b) for a, b in beside if b in points]
    lanes = [{"from": a, "to": b, "one_way": True} for pair in pairs for a, b in (pair, pair[::-1])]
    aside = ([2 * (i % side) + 1, 2 * (i // side) + 1] for i in range(robots))
    starts = [*points, *aside][:robots]
    kind = {"base": {"radius": 0.2}, "components": {"battery": {}}}
    return {
        "waypoints": points,
        "lanes": lanes,
        "walls": [[[2 * i - 0.5, -5], [2 * i + 0.5, -5]] for i in range(1_500)],
        "docks": {f"d{i}": {"at": f"w{i}_0"} for i in range(side)},
        "robot_types": {"t": kind},
        "robots": {f"r{i}": {"at": at, "type": "t"} for i, at in enumerate(starts)},
        "traffic": {"policy": "planned"},
    }


def test_a_large_fleet_is_no_error():
    data = _lattice(25, 1_000)

    assert (625, 2_400, 1_000) == (len(data["waypoints"]), len(data["lanes"]), len(data["robots"]))
    assert [] == _errors(data)


@pytest.mark.parametrize("name", ["hospital_fleet", "hospital_logistics", "warehouse_orders", "cafe"])
def test_shipped_worlds_with_300_robots_are_no_error(name):
    world = load_world(name).world
    points = [*world.waypoints]
    robots = {f"r{i}": {"at": points[i % len(points)]} for i in range(300)}

    data = world.model_dump(mode="json", by_alias=True, exclude_defaults=True) | {"robots": robots}
    assert [] == _errors(data)


def test_files_have_no_such_limit():
    """Only the user who loads the file waits for it."""
    world_of(TOO_LARGE["robots with docks"], "test")


def test_the_estimate_equals_the_number_of_comparisons(monkeypatch):
    compared: list[int] = []
    compare = nearness._compare
    monkeypatch.setattr(
        nearness,
        "_compare",
        lambda shapes, *rest: (compared.append(len(shapes) * (len(shapes) - 1) // 2), compare(shapes, *rest)),
    )
    points = [(float(i % 7), float(i // 7)) for i in range(49)]
    ends = {i: (i, (i * 5) % 49) for i in range(49)}

    near_slots(points, ends, 0.5)
    assert sum(compared) == comparisons(points, ends, 0.5) > 0
