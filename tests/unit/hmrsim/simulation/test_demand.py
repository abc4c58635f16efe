"""Orders of the demand, from their creation to their delivery."""

from __future__ import annotations

import json
from typing import Any

import pytest

from hmrsim.errors import WorldError
from hmrsim.testing import Run, simulation
from hmrsim.world_checks.loading import world_of
from tests.calls import calls_of
from tests.simulation import simulate

WORLD: dict[str, Any] = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0]},
    "lanes": [["a", "b"], ["b", "c"]],
    "robots": {"w": {"at": "a", "type": "fetcher"}},
    "demand": [{"name": "sample", "item": "blood", "at": "b", "to": "c", "arrives": 30, "within": 45, "count": 3}],
}


def world(**demand: Any) -> dict[str, Any]:
    """Return the world with some keys of its demand changed."""
    changed = {**WORLD["demand"][0], **demand}
    return {**WORLD, "demand": [{key: value for key, value in changed.items() if value is not None}]}


def bring(run: Run, item: str) -> None:
    """Make the robot bring an item from b to c."""
    robot = run.commander("w")
    robot.go_to_pose(10.0, 0.0)
    robot.pickup(item)
    robot.go_to_pose(20.0, 0.0)
    robot.place(item)


def ask(run: Run, service: str, **fields: Any) -> Any:
    """Return the answer of a service of the world."""
    return json.loads(run.client.get(run.client.keys.world(service), payload=json.dumps(fields).encode()))


def test_an_order_is_delivered_when_its_item_lies_at_its_destination() -> None:
    """Its item then leaves the world."""
    with simulation(WORLD) as run:
        run.client.sleep(31)
        assert ["blood_1"] == [order.item for order in run.orders("open")]
        bring(run, "blood_1")
        run.client.sleep(0)
        (order,) = run.orders("delivered")

        assert (order.name, order.robot, order.late, "blood_1" in run.simulator.items) == (
            "sample_1",
            "w",
            False,
            False,
        )
        (delivered,) = run.happened("order_delivered")
        assert delivered.fields["lead_time"] == pytest.approx(run.now - 30.0)
        assert ["order_placed", "order_picked_up"] == [each.kind for each in run.happened() if "order" in each.kind][:2]


def test_an_order_tells_its_demand_and_the_weight_of_its_item() -> None:
    with simulation(world(weight=2.5)) as run:
        run.client.sleep(40)
        (placed,) = run.happened("order_placed")

        assert ("sample", 2.5) == (placed.fields["demand"], placed.fields["weight"])


def test_an_order_that_is_not_served_is_late_and_stays_open() -> None:
    with simulation(WORLD) as run:
        run.client.sleep(80)
        assert [75.0] == [each.at for each in run.happened("order_late")]
        bring(run, "blood_1")
        run.client.sleep(0)

        assert run.happened("order_delivered")[0].fields["late"] == pytest.approx(run.now - 75.0)
        totals = run.simulator.demand.totals
        assert (totals.delivered, totals.late) == (1, len(run.happened("order_late")))


def test_an_item_put_down_elsewhere_waits_again() -> None:
    with simulation(world(within=None)) as run:
        run.client.sleep(31)
        robot = run.commander("w")
        robot.go_to_pose(10.0, 0.0)
        robot.pickup("blood_1")
        assert "carried" == run.orders("open")[0].state
        robot.place("blood_1")
        run.client.sleep(0)
        assert ("waiting", "") == (run.orders("open")[0].state, run.orders("open")[0].robot)
        robot.pickup("blood_1")
        robot.go_to_pose(20.0, 0.0)
        robot.place("blood_1")
        run.client.sleep(0)

        assert 2 == len(run.happened("order_picked_up"))
        assert 31.0 <= run.orders("delivered")[0].picked_up < 45.0


def test_an_order_whose_item_is_deleted_is_lost() -> None:
    """It counts as lost, and never as late."""
    with simulation(WORLD) as run:
        run.client.sleep(31)
        ask(run, "delete_entity", entity="blood_1")
        run.client.sleep(60)

        assert ["order_lost"] == [each.kind for each in run.happened() if each.fields.get("order") == "sample_1"][1:]
        assert 1 == run.simulator.demand.totals.lost


def test_orders_are_limited_by_number_time_and_open_orders() -> None:
    with simulation(world(count=3)) as run:
        run.client.sleep(1000)
        assert [30.0, 60.0, 90.0] == [each.at for each in run.happened("order_placed")]
    with simulation(world(count=None, until=100, first=5)) as run:
        run.client.sleep(1000)
        assert [5.0, 35.0, 65.0, 95.0] == [each.at for each in run.happened("order_placed")]
    with simulation(world(count=None, most_open=2)) as run:
        run.client.sleep(100)
        assert [30.0, 60.0] == [each.at for each in run.happened("order_placed")]
        bring(run, "blood_1")
        ended = run.now
        run.client.sleep(40)
        assert pytest.approx(ended + 30) == run.happened("order_placed")[2].at


def test_an_order_costs_the_same_however_many_are_open() -> None:
    def cost(demands: int) -> int:
        said = [{"name": f"d{number}", "at": "b", "to": "c", "arrives": 1, "count": 2} for number in range(demands)]
        run = simulate({**WORLD, "demand": said}, topics=frozenset())
        calls = calls_of(lambda: run.simulator.run(3.0))
        assert 2 * demands == run.simulator.demand.totals.placed
        return calls

    assert cost(400) < 5 * cost(100)


def test_a_reset_removes_all_orders_and_repeats_them() -> None:
    chance = world(arrives={"exponential": {"mean": 20}}, at=["a", "b"], count=5)
    with simulation(chance) as run:
        run.client.sleep(200)
        placed = [(each.at, each.fields["from"]) for each in run.happened("order_placed")]
        ask(run, "reset_simulation")
        assert [] == run.orders()
        assert {} == run.simulator.items
        run.client.sleep(200)

        again = [(each.at, each.fields["from"]) for each in run.happened("order_placed")][len(placed) :]
        assert placed == again
        assert {"a", "b"} == {where for _, where in placed}


def test_a_client_places_an_order_in_any_world() -> None:
    """An invalid order is answered with the reason, and `get_orders` lists valid ones."""
    with simulation({**WORLD, "demand": []}) as run:
        bad = ask(run, "place_order", at="b", to="nowhere")
        assert "no waypoint, place or dock 'nowhere'" in bad["result"]["error_message"]
        bad = ask(run, "place_order", at="b", to="c", within=-3.0)
        assert "within: must be greater than 0, got -3" in bad["result"]["error_message"]
        good = ask(run, "place_order", at="b", to="c", item="soup")
        assert ("order_1", "soup_1", "waiting") == (
            good["order"]["name"],
            good["order"]["item"],
            good["order"]["state"],
        )
        bring(run, "soup_1")
        run.client.sleep(0)
        answer = ask(run, "get_orders", state="delivered")

        assert [("order_1", "w")] == [(order["name"], order["robot"]) for order in answer["orders"]]
        assert (1, 1) == (answer["placed"], answer["delivered"])
        assert "no state 'done'" in ask(run, "get_orders", state="done")["result"]["error_message"]


def test_two_controllers_under_one_seed_get_the_same_orders() -> None:
    chance = world(arrives={"exponential": {"mean": 20}}, at=["a", "b"], within={"uniform": {"low": 9, "high": 99}})

    def met(*, busy: bool) -> list[dict[str, Any]]:
        with simulation(chance) as run:
            run.client.sleep(40)
            if busy:
                run.commander("w").go_to_pose(20.0, 0.0)
            run.client.sleep(100)
            return [each.fields for each in run.happened("order_placed")]

    assert met(busy=True) == met(busy=False)


@pytest.mark.parametrize(
    ("demand", "said"),
    [
        ({"at": ["b", "bb"]}, "demand.0.at: no waypoint, place or dock 'bb'; did you mean 'b'?"),
        ({"to": "nowhere"}, "demand.0.to: no waypoint, place or dock 'nowhere'"),
        ({"arrives": 0}, "demand.0.arrives: must be greater than 0, got 0"),
        ({"at": []}, "demand.0.at: expected at least 1 values, got 0"),
        ({"every": 3}, "demand.0.every: unknown key 'every'"),
        ({"name": "a b"}, "demand.0.name"),
    ],
)
def test_errors_in_a_demand_have_their_place(demand: dict[str, Any], said: str) -> None:
    with pytest.raises(WorldError) as error:
        world_of(world(**demand), "w")
    assert said in str(error.value)


def test_duplicate_names_of_demands_and_items_are_errors() -> None:
    twice = {**WORLD, "demand": WORLD["demand"] * 2, "items": {"blood_7": {"at": "a"}}}
    with pytest.raises(WorldError) as error:
        world_of(twice, "w")
    assert "demand.1.name: there is a demand 'sample' already" in str(error.value)
    assert "demand.0.item: its items are called blood_1 and so on, as 'blood_7' is already" in str(error.value)


def test_the_topic_of_orders_is_published_when_one_changes() -> None:
    with simulation(WORLD) as run:
        seen: list[dict[str, Any]] = []
        run.client.subscribe(run.client.keys.world("demand"), lambda _key, payload: seen.append(json.loads(payload)))
        run.client.sleep(31)
        bring(run, "blood_1")
        run.client.sleep(0)

        assert ["waiting", "carried"] == [each["orders"][0]["state"] for each in seen[:2]]
        assert {"placed": 1, "delivered": 1, "late": 0, "lost": 0} == seen[-1]["totals"]
