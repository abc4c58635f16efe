"""Single runs of an experiment: their endings and measures."""

from __future__ import annotations

import sys
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import pytest
import yaml

from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.replications import Task, execute, execute_run
from hmrsim.report.delays import PARTS
from hmrsim.testing import simulation
from hmrsim.trace.replay import replay
from hmrsim.trials.trial import CRASHED, ERROR, HUNG, TIMEOUT
from hmrsim.world_checks import loading
from hmrsim_zenoh import Commander
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from hmrsim.experiments.store import Row

NOTHING: Mapping[str, Any] = MappingProxyType({})

WORLD = {
    "name": "two",
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0]},
    "lanes": [["a", "b"], {"from": "b", "to": "c", "speed_factor": {"uniform": {"low": 0.2, "high": 1}}}],
    "robots": {"w": {"at": "a", "type": "fetcher", "components": {"battery": {"capacity": 1000}}}},
    "items": {"box": {"at": "b"}},
}

CONTROLLER = """\
import asyncio
import sys
import time
from contextlib import suppress

from py_trees.composites import Sequence
from bt_controller.behaviours.robot_actions import Pickup, Place
from bt_controller.behaviours.robot_actions import GoTo
from hmrsim_zenoh import Commander, GoalFailed, GoalRejectedError


def bring(robot, item="box"):
    steps = [GoTo("b"), Pickup(item), GoTo("c"), Place(item), GoTo("a")]
    return Sequence("Bring", memory=True, children=steps)


def drive(client, x=20.0):
    Commander(client, "w").go_to_pose(float(x), 0.0)


async def drives(robots, x=20.0):
    await robots.robot("w").navigate_to((float(x), 0.0))
    return x < 20


def rounds(client):
    for n in range(3):
        drive(client, 10.0 * (n % 2))
    client.end_run("tired", rounds=3, why="no more")
    drive(client)


def takes(client, x, robot="w"):
    print(x, type(x).__name__, robot)
    Commander(client, robot).go_to_pose(float(x), 0.0)


def assigns(client, robot):
    client.end_run("assigned", executor=robot, target="c", way=20.0)
    for name in ("w", "v"):
        drive_of(client, name, 10.0)
    drive_of(client, robot, 20.0)
    drive_of(client, robot, 10.0)


def drive_of(client, robot, x):
    Commander(client, robot).go_to_pose(float(x), 0.0)


def says_no(client):
    print("no luck")
    return False


def raises(client):
    drive(client, 10.0)
    raise RuntimeError("boom")


def exits(client):
    sys.exit(4)


def wavers(client, calls=[]):
    calls.append(0)
    drive(client, 5.0 + len(calls))


def goes_far_once(client, calls=[]):
    calls.append(0)
    drive(client, 20.0 if len(calls) == 1 else 10.0)


def sleeps(client):
    time.sleep(60)


def computes(client):
    while True:
        pass


def insists(client):
    while True:
        with suppress(GoalFailed):
            Commander(client, "w").do("dock_robot", {"dock_id": "nowhere"})


def insists_on_what_is_rejected(client):
    while True:
        with suppress(GoalRejectedError):
            Commander(client, "v").wait(1)


async def dies_unseen(robots):
    async def work():
        raise KeyError("mine")

    asyncio.create_task(work())
    while True:
        await robots.sleep(10)


def goes_on(client):
    while True:
        drive(client, 0.0)
        drive(client, 20.0)
"""


@pytest.fixture
def row(tmp_path):
    """Return the result of a run of a controller."""

    def made(
        controller: str | list[str],
        *,
        number: int = 0,
        kind: str = "python",
        given: Mapping[str, Any] = NOTHING,
        own: Mapping[str, Any] = NOTHING,
        chosen: Sequence[str] = (),
        **changes: Any,
    ) -> Row:
        (tmp_path / "two.yaml").write_text(yaml.safe_dump(WORLD), encoding="utf-8")
        name = f"controller_{abs(hash(str(tmp_path)))}.py"
        (tmp_path / name).write_text(CONTROLLER, encoding="utf-8")
        run_by = f"{name}:{controller}" if isinstance(controller, str) else controller
        content = {
            "name": "e",
            "world": "two.yaml",
            "treatments": {"t": {kind: run_by, "set": {**given}, "overlay": {**own}}},
            "replications": 5,
            "limits": {"simulated": 300, "wall": PATIENCE},
            "measures": {"time": "end.at", "energy": "energy"},
            **changes,
        }
        (tmp_path / "e.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
        plan = read_plan(tmp_path / "e.yaml", chosen)
        run = plan.run_of(number)
        assert run is not None
        return execute_run(plan, run)

    return made


def test_the_controllers_outcome_ends_a_run_if_nothing_else_does(row):
    good, bad = row("drive"), row("says_no")
    assert (good.ending, good.success, good.cause) == ("succeeded", True, "")
    assert good.at == good.measures["time"] == pytest.approx(good.measures["energy"])
    assert (bad.ending, bad.success, bad.at, bad.output) == ("failed", False, 0.0, "no luck")


def test_a_coroutine_function_is_a_controller(row):
    near, far = row("drives(x=10)"), row("drives")

    assert (near.ending, near.at) == ("succeeded", 10.0)
    assert far.ending == "failed"
    assert far.at == pytest.approx(row("drive").at)


def test_a_tree_runs_with_its_parameters(row):
    done = {"done": {"item": "box", "at": "c", "carried": False}}
    assert row("bring", kind="tree", ends=done).ending == "done"
    assert row("bring(item='box')", kind="tree").ending == "succeeded"
    assert "it takes no 'itm'" in row("bring(itm='box')", kind="tree").cause


def test_the_simulator_ends_a_run_at_the_instant_at_which_an_ending_holds(row):
    placed = row("bring", kind="tree", ends={"success": {"item": "box", "at": "c", "carried": False}})
    assert (placed.ending, placed.success) == ("success", True)
    carried = row("bring", kind="tree", ends={"success": {"item": "box", "at": "b", "carried": True}})
    assert carried.at == 10.0 < placed.at
    there = row("drive(x=10)", ends={"success": {"robot": "w", "at": "b"}})
    assert (there.ending, there.at) == ("success", 10.0)
    event = row("bring", kind="tree", ends={"picked": {"event": "picked", "where": {"item": "box"}}})
    assert (event.ending, event.at) == ("picked", 10.0)
    other = row("bring", kind="tree", ends={"picked": {"event": "picked", "where": {"item": "vase"}}})
    assert other.ending == "succeeded"


def test_a_controller_reports_how_a_run_has_ended(row):
    ends = {"worn_out": {"reported": "tired"}}
    found = row("rounds", ends=ends, measures={"n": "reported.rounds", "m": "reported.nothing"}, successes=["worn_out"])
    assert (found.ending, found.success, found.at, found.cause) == ("worn_out", True, 20.0, "")
    assert found.measures == {"n": 3.0, "m": None}
    assert found.reported == {"label": "tired", "rounds": 3, "why": "no more"}


def test_first_condition_that_holds_counts(row):
    ends = {"any": [{"robot": "w", "at": "c"}, {"robot": "w", "at": "b"}], "late": {"controller": "succeeded"}}
    assert (row("rounds", ends=ends).ending, row("rounds", ends=ends).at) == ("any", 10.0)
    assert row("drive(x=5)", ends=ends).ending == "late"
    assert row("says_no", ends={"lost": {"controller": "failed"}}).ending == "lost"


def test_a_run_that_reaches_its_limit_ends_there(row):
    found = row("goes_on", limits={"simulated": 100, "wall": PATIENCE})
    assert (found.ending, found.at, found.success) == (TIMEOUT, 100.0, False)


def test_failed_task_is_the_cause_of_a_timeout(row):
    found = row("dies_unseen", limits={"simulated": 100, "wall": PATIENCE})
    assert (found.ending, found.at) == (TIMEOUT, 100.0)
    assert "a task of the controller had died of KeyError: 'mine' (" in found.cause
    assert ".py:" in found.cause


def test_a_controller_that_takes_too_long_is_ended(row):
    found = row("sleeps", limits={"wall": 0.3})
    assert (found.ending, found.at) == (HUNG, 0.0)
    assert "it has waited for 0.3 wall seconds without computing anything" in found.cause


def test_a_controller_that_computes_too_long_is_ended_by_its_processor_time(row):
    found = row("computes", limits={"wall": 0.05, "processor": 0.3})
    assert (found.ending, found.at) == (HUNG, 0.0)
    assert "it takes longer than 0.3 s of processor time" in found.cause


def test_the_limit_of_processor_time_is_that_of_wall_time_if_left_out(row):
    assert "it takes longer than 0.2 s of processor time" in row("computes", limits={"wall": 0.2}).cause


@pytest.mark.parametrize(
    ("controller", "cause"),
    [
        ("insists", "1,000 goals of w/dock_robot failed within one instant; the last one: no dock 'nowhere'"),
        ("insists_on_what_is_rejected", "1,000 goals of v/wait failed within one instant; the last one: no robot 'v'"),
    ],
)
def test_a_controller_that_lets_no_time_pass_is_ended(row, controller, cause):
    """It ends long before the wall limit, and its cause names the goal that it repeats."""
    found = row(controller, limits={"wall": PATIENCE}, replications=1)
    assert (found.ending, found.at, found.success) == (HUNG, 0.0, False)
    assert f"time stands still: {cause}" in found.cause


def test_a_controller_that_raises_an_error_is_a_row_with_its_cause(row):
    found = row("raises", keep={"traces": "failed"})
    assert (found.ending, found.at) == (CRASHED, 10.0)
    assert "RuntimeError: boom" in found.cause
    assert ".py:" in found.cause
    assert replay(found.trace.splitlines(keepends=True)).difference is None
    assert "SystemExit: 4" in row("exits").cause
    assert row("drive", keep={"traces": "failed"}).trace == ""


def test_invalid_world_is_a_row(row):
    found = row("drive", overlay={"robots.w.at": "nowhere"})
    assert (found.ending, found.at) == (ERROR, None)
    assert "no waypoint, place or dock 'nowhere'" in found.cause


def test_measures_are_expressions_over_the_truth(row):
    measures = {
        "late": "end.at - 10",
        "share": "goals.succeeded / goals.accepted",
        "x": "robots.w.x",
        "battery": "robots.w.battery",
        "won": "ends.success",
        "driven": "report.summary.distance",
        "wrong": "orders.lead_time.mean * 2",
    }
    found = row("bring", kind="tree", ends={"success": {"item": "box", "at": "c"}}, measures=measures)
    assert found.measures["late"] == found.at - 10
    assert found.measures["share"] == pytest.approx(3 / 3)
    assert (found.measures["x"], found.measures["won"], found.measures["wrong"]) == (20.0, 1.0, None)
    assert found.measures["battery"] == pytest.approx(1 - found.at / 1000)
    assert found.measures["driven"] == pytest.approx(20.0)
    assert found.cause == "wrong: there is no value to calculate with"


def test_a_run_is_the_same_each_time_and_its_replications_are_not(row):
    assert [row("drive", number=i).at for i in (0, 1, 0)] == [row("drive", number=i).at for i in (0, 1, 0)]
    assert len({row("drive", number=i).at for i in range(5)}) == 5


@pytest.mark.parametrize(
    ("controller", "kinds"),
    [("drive(x=10)", 1), ("drive", None), ("wavers", 3)],
    ids=["no chance on the way", "a speed by chance", "a controller's own chance"],
)
def test_replications_without_random_numbers_have_fingerprints(row, controller, kinds):
    found = [row(controller, number=number).fingerprint for number in range(3)]

    if kinds is None:
        assert ["", "", ""] == found
    else:
        assert (True, kinds) == (all(found), len({*found}))


def test_a_replication_without_random_numbers_has_a_fingerprint_after_one_with_them(row, tmp_path):
    """Its trace was not recorded at first, as the replication before did not need one."""
    row("goes_far_once")
    known, fresh = (read_plan(tmp_path / "e.yaml") for _ in range(2))
    known.left_to_chance.add((0, "t"))

    first, again = (execute_run(plan, plan.run(0, "t", 1)) for plan in (known, fresh))
    assert first.fingerprint == again.fingerprint != ""
    assert first.at == again.at == 10.0


def test_parameters_are_arguments_of_the_function(row):
    """They keep their types, unless the text of the function uses them."""
    assert "5 int w" == row("takes", given={"x": 5}).output
    assert "7.5 str w" == row("takes(x='${far}')", given={"far": 7.5, "robot": "w"}).output
    assert "it takes no 'y'" in row("takes", given={"x": 5, "y": 6}).cause


def test_parameters_of_a_variant_replace_those_of_treatments(row):
    changes = {
        "given": {"x": 5},
        "variants": {"far": {"set": {"x": 15}, "robots.w.base.speed": 2.0}, "slow": {"set": {"x": "${2 + 6}"}}},
    }

    assert ("5 int w", 5.0) == ((plain := row("takes", **changes)).output, plain.at)
    assert "15 int w" == row("takes", chosen=["far"], **changes).output
    assert ("8 int w", 4.0) == ((both := row("takes", chosen=["far", "slow"], **changes)).output, both.at)


def test_trees_and_commands_can_use_parameters(row):
    assert row("bring(item='${what}')", kind="tree", given={"what": "box"}).ending == "succeeded"
    command = [sys.executable, "-c", "import os, sys; print(os.environ['GREETING'], *sys.argv[1:])", "${what}"]
    assert "hello box" == row(command, kind="command", given={"what": "box", "GREETING": "hello"}).output


def test_overlay_of_a_treatment_changes_its_world_alone(row):
    """It is applied after those of the file and the variants."""
    changes = {"overlay": {"robots.w.base.speed": 5.0}, "variants": {"slow": {"robots.w.base.speed": 0.5}}}

    assert 2.0 == row("drive(x=10)", **changes).at
    assert 20.0 == row("drive(x=10)", chosen=["slow"], **changes).at
    own = {"robots.w.base.speed": 2.0}
    assert 5.0 == row("drive(x=10)", chosen=["slow"], own=own, **changes).at


@pytest.mark.parametrize(
    ("condition", "at"),
    [
        ({"robot": "${reported.executor}", "at": "c"}, 30.0),
        ({"robot": "${reported.executor}", "at": "${reported.target}"}, 30.0),
        ({"robot": "${reported.executor}", "at": "a"}, 0.0),
        ({"event": "status", "where": {"robot": "${reported.executor}", "status": 4}}, None),
        ({"robot": "${reported.nobody}", "at": "c"}, None),
        ({"robot": "${reported.executor}", "at": "${reported.way}"}, None),
        ({"robot": "${reported.executor}", "at": "${reported.executor}"}, None),
    ],
)
def test_an_ending_may_name_the_robot_that_the_controller_reports(row, condition, at):
    lanes = [["a", "b"], ["b", "c"]]
    overlay = {"robots.v": {"at": "a", "type": "fetcher"}, "lanes": lanes, "traffic": {"policy": "free"}}
    found = row("assigns(robot='v')", overlay=overlay, ends={"there": condition})

    assert ("succeeded" if at is None else "there") == found.ending
    assert at is None or at == found.at


def test_single_replication_has_no_fingerprint(row):
    assert "" == row("drive(x=10)", replications=1).fingerprint


def test_the_trace_is_that_of_a_test_of_the_same_run(tmp_path, row):
    found = row("drive(x=10)", keep={"traces": "all"}, measures={})
    with simulation(str(tmp_path / "two.yaml")) as run:
        Commander(run.open_client("drive"), "w").go_to_pose(10.0, 0.0)
    ours, theirs = found.trace.splitlines(), run.trace.splitlines()
    assert ours[1:4] == theirs[1:4]
    assert replay(found.trace.splitlines(keepends=True)).difference is None


def test_a_function_is_a_participant_by_its_own_name(row):
    trace = row("drive(x=10)", keep={"traces": "all"}, measures={}).trace

    assert '"participant":"drive"' in trace
    assert "bt_controller" not in trace


def test_orders_that_are_served_end_a_run(row, tmp_path):
    world = {**WORLD, "items": {}, "demand": [{"name": "box", "at": "b", "to": "c", "arrives": 5, "count": 1}]}
    row("drive")  # writes the files
    (tmp_path / "served.yaml").write_text(yaml.safe_dump(world), encoding="utf-8")
    tree = "bring(item='box_1')"
    found = row(
        tree,
        kind="tree",
        world="served.yaml",
        ends={"success": {"orders": "served"}},
        measures={"lead": "orders.lead_time.max", **{part: f"orders.delay.{part}" for part in PARTS}},
    )
    assert (found.ending, found.measures["lead"]) == ("success", pytest.approx(found.at - 5.0))
    assert found.measures["lead"] == pytest.approx(sum(found.measures[part] for part in PARTS))
    assert found.measures["travel"] > 0


def test_task_runs_known_numbers_of_an_unchanged_plan(row, tmp_path):
    row("drive")
    plan = read_plan(tmp_path / "e.yaml")
    rows = execute(Task(str(plan.path), (), plan.hash, (2, 0, 99)))
    assert [each.run.number for each in rows] == [2, 0]
    with pytest.raises(Exception, match="has changed since the experiment was started"):
        execute(Task(str(plan.path), (), "another", (0,)))


def test_world_is_hashed_once_for_all_its_runs(row, tmp_path, monkeypatch):
    hashed: list[str] = []
    monkeypatch.setattr(loading, "_digest", lambda world: hashed.append(world.name) or f"{len(hashed)}")
    row("drive", keep={"traces": "all"})
    plan = read_plan(tmp_path / "e.yaml")

    traces = [execute_run(plan, run).trace for number in range(3) if (run := plan.run_of(number)) is not None]

    assert ["two"] == hashed
    assert ['"hash":"1"' in trace for trace in traces] == [True] * 3
