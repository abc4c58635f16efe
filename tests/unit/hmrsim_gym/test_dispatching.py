"""What becomes of orders when goals fail, and of robots when batteries are low."""

from __future__ import annotations

from itertools import pairwise

import pytest

pytest.importorskip("gymnasium", reason="environments need the extra gym")

from hmrsim_gym.dispatching import REST, Dispatching
from hmrsim_gym.setting import Setting


@pytest.fixture
def begin(world):
    """Return what begins a run up to its first decision."""
    runs = []

    def run(**arguments):
        runs.append(Dispatching(Setting.of(world, **arguments), 1))
        runs[-1].run_on()
        return runs[-1]

    yield run
    for each in runs:
        each.close()


def test_an_order_whose_pickup_fails_is_free_again(begin, world):
    """Another robot may have it at once; the one that has failed rests."""
    world["demand"][0] |= {"weight": 50, "count": 1}
    run = begin()
    (order,) = run.free

    run.wait("eve")
    run.assign("wall_e", order)
    run.run_on()

    assert (["parcel_1"], ["eve"], "rests") == ([order.name for order in run.free], run.asking, run.doing("wall_e"))


def test_a_robot_that_has_failed_is_given_other_orders_first(begin, world):
    """Not the same one, for a minute."""
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


def test_an_order_that_can_not_be_brought_is_laid_down(begin, world):
    """It is free again where the robot has laid it down, and the other robot delivers it."""
    world["demand"][0] |= {"at": ["store"], "count": 1}
    world["traffic"]["patience"] = 5
    world["faults"] = [{"type": "lane_closed", "lane": ["door", "ward"], "at": 17, "duration": 60}]
    run = begin(robots=["wall_e"])
    run.assign("wall_e", run.free[0])
    run.run_on()

    assert (["parcel_1"], "waiting") == ([order.name for order in run.free], run.free[0].state.value)


def test_a_robot_whose_battery_is_low_charges_before_it_serves(begin, world):
    """It goes to the charger on its own, and is asked when it is charged."""
    world["docks"] = {"charger": {"at": [0, 2], "staging": [0, 0], "type": "charger", "power": 20}}
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 600, "initial_charge": 120}
    run = begin(robots=["wall_e"])

    assert run.truth.battery("wall_e") == pytest.approx(0.8, abs=0.01)
    assert 15 < run.now < 40


def test_a_robot_that_is_lost_keeps_nobody_waiting(begin, world):
    """Its battery is empty: others serve the orders that are left."""
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 20}
    run = begin()
    run.assign(run.asking[0], run.free[0])
    while not run.over:
        run.run_on()
        for robot in run.asking[:1]:
            run.assign(robot, run.choices(robot)[0])

    assert run.demand.totals.delivered >= 3


def test_an_idle_robot_charges_as_soon_as_its_battery_is_low(begin, world):
    """Also while nothing else happens; a charger that is free is preferred to one that is near."""
    charger = {"type": "charger", "power": 20}
    world["docks"] = {"near": {"at": [0, 2], "staging": [0, 0], **charger}, "far": {"at": [10, 2], **charger}}
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 100}
    world["robots"]["cart"]["at"] = "near"
    world["demand"][0] |= {"first": 300}
    run = begin(robots=["wall_e"])

    assert (300.0, (10.0, 2.0)) == (run.now, run.truth.point("wall_e"))
    assert run.truth.battery("wall_e") > 0.25
