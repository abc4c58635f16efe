"""Orders whose goals fail, and robots whose batteries are low."""

from __future__ import annotations

from itertools import pairwise

import pytest

pytest.importorskip("gymnasium", reason="environments need the extra gym")

from hmrsim_gym.dispatching import REST, Dispatching
from hmrsim_gym.setting import Setting


@pytest.fixture
def begin(world):
    """Return a function that begins a run and lets time pass until its first decision."""
    runs = []

    def run(**arguments):
        runs.append(Dispatching(Setting.of(world, **arguments), 1))
        runs[-1].run_on()
        return runs[-1]

    yield run
    for each in runs:
        each.close()


def test_an_order_whose_pickup_fails_is_free_again(begin, world):
    """Another robot may serve it at once, while the first one rests."""
    world["demand"][0] |= {"weight": 50, "count": 1}
    run = begin()
    (order,) = run.free

    run.wait("eve")
    run.assign("wall_e", order)
    run.run_on()

    assert (["parcel_1"], ["eve"], "rests") == ([order.name for order in run.free], run.asking, run.doing("wall_e"))


def test_failed_order_is_not_offered_to_the_robot_for_a_minute(begin, world):
    world["demand"][0] |= {"weight": 50, "count": 1}
    run = begin(robots=["wall_e"], horizon=200)
    failed = []
    while not run.over:
        failed.append(run.now)
        run.assign("wall_e", run.free[0])
        run.run_on()

    gaps = {round(later - before) for before, later in pairwise(failed)}
    assert REST < min(gaps)
    assert max(gaps) < 80


def test_undeliverable_item_is_put_down_and_free_again(begin, world):
    world["demand"][0] |= {"at": ["store"], "count": 1}
    world["traffic"]["patience"] = 5
    world["faults"] = [{"type": "lane_closed", "lane": ["door", "ward"], "at": 17, "duration": 60}]
    run = begin(robots=["wall_e"])
    run.assign("wall_e", run.free[0])
    run.run_on()

    assert (["parcel_1"], "waiting") == ([order.name for order in run.free], run.free[0].state.value)


def test_robot_with_a_low_battery_charges_before_it_serves(begin, world):
    world["docks"] = {"charger": {"at": [0, 2], "staging": [0, 0], "type": "charger", "power": 20}}
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 600, "initial_charge": 120}
    run = begin(robots=["wall_e"])

    assert run.truth.battery("wall_e") == pytest.approx(0.8, abs=0.01)
    assert 15 < run.now < 40


def test_robot_with_an_empty_battery_does_not_block_the_others(begin, world):
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 20}
    run = begin()
    run.assign(run.asking[0], run.free[0])
    while not run.over:
        run.run_on()
        for robot in run.asking[:1]:
            run.assign(robot, run.choices(robot)[0])

    assert run.demand.totals.delivered >= 3


def test_an_idle_robot_charges_as_soon_as_its_battery_is_low(begin, world):
    """It prefers a free charger to a nearer one that is occupied."""
    charger = {"type": "charger", "power": 20}
    world["docks"] = {"near": {"at": [0, 2], "staging": [0, 0], **charger}, "far": {"at": [10, 2], **charger}}
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 100}
    world["robots"]["cart"]["at"] = "near"
    world["demand"][0] |= {"first": 300}
    run = begin(robots=["wall_e"])

    assert (300.0, (10.0, 2.0)) == (run.now, run.truth.point("wall_e"))
    assert run.truth.battery("wall_e") > 0.25
