"""The log of a run: what its page shows."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.failure_page import run_logged
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.run import Wanted, run_case
from hmrsim.fault_search.schedule import Case
from hmrsim.run_page import run_log
from hmrsim.run_page.run_log import RunLog, Tree
from tests.porters import WORLD
from tests.simulation import B, at, go, simulate
from tests.unit.hmrsim.run_page.conftest import BREAKDOWN


def node(name, status="RUNNING", message="", depth=0):
    status = SimpleNamespace(value=status)
    return SimpleNamespace(depth=depth, kind="Leaf", name=name, ports="", status=status, message=message)


def test_the_log_does_not_change_the_run(check, failing):
    assert run_case(check, Case((BREAKDOWN,)), Wanted(trace=True)).trace == failing[0].trace


def test_lines_have_the_events_with_the_names_of_places(passing):
    texts = [f"{line.at:g} {line.subject} {line.text}" for line in passing[1].lines]

    assert "0 porter navigate_to_pose accepted: store" in texts
    assert "10 porter picks up box" in texts
    assert any(text.endswith("porter puts down box at shelf") for text in texts)


def test_a_rejected_goal_has_its_target_and_the_places_of_its_reason(failing):
    texts = [line.text for line in failing[1].lines if " rejected" in line.text]

    assert "pickup rejected (box): porter has broken down at store" in texts


def test_goals_that_end_with_the_simulation_have_no_end(failing):
    goals = failing[1].report().goals

    assert {"SUCCEEDED", "ABORTED"} == {goal.status for goal in goals if goal.ended is not None}
    assert not [line for line in failing[1].lines if "stopped" in line.text]


def test_robots_are_where_they_were(passing):
    frames = passing[1].poses["porter"].frames

    assert (0.0, 0.0) == frames[0][1:3]
    assert {(10.0, 0.0), (20.0, 0.0)} <= {(round(x, 6), round(y, 6)) for _, x, y, _ in frames}
    assert (0.0, 0.0) == (round(frames[-1].x, 6), round(frames[-1].y, 6))


def test_items_are_carried(passing):
    log = passing[1]
    boxes = log.changes("item")["box"]

    assert [(10.0, 0.3), "porter"] == [change.value for change in boxes][:2]
    assert "picks up box" == log.lines[boxes[1].line - 1].text


def test_goals_and_states_change_with_their_event(passing):
    log = passing[1]
    goals = [(log.lines[change.line - 1].text, change.value) for change in log.changes("goals")["porter"]]
    at_store = [change.value for change in log.changes("state")["porter"] if change.at == pytest.approx(10.0)]

    assert ("navigate_to_pose accepted: store", ["navigate_to_pose store"]) == goals[0]
    assert ("navigate_to_pose SUCCEEDED (store)", []) == goals[1]
    assert ["busy", "idle", "busy"] == at_store[:3]


def test_nodes_of_a_tree_in_xml_have_their_ports(tmp_path):
    tree = (
        '<root BTCPP_format="4"><BehaviorTree ID="Fetch"><Sequence><NavigateToPose goal="store"/>'
        '<Pickup target_name="box"/></Sequence></BehaviorTree></root>'
    )
    (tmp_path / "fetch.xml").write_text(tree, encoding="utf-8")
    said = {"world": WORLD, "controller": {"tree": "fetch.xml", "robots": ["porter"]}}
    _, log = run_logged(check_at(CheckFile.model_validate(said), tmp_path), Case(), Wanted())

    (shape,) = log.trees["porter"].shapes
    ports = [("Sequence", ""), ("NavigateToPose", "goal: store"), ("Pickup", "target_name: box")]
    assert ports == [node[2:] for node in shape]


def test_ticks_that_change_nothing_are_left_out():
    tree = Tree()
    tree.note(1.0, 0, [node("drive")])
    tree.note(2.0, 3, [node("drive")])
    tree.note(3.0, 4, [node("drive", "SUCCESS", "there")])

    assert [(1.0, "R", {}), (3.0, "S", {0: "there"})] == [
        (tick.at, tick.statuses, tick.messages) for tick in tree.ticks
    ]


def test_a_tree_may_grow():
    tree = Tree()
    tree.note(1.0, 0, [node("root")])
    tree.note(2.0, 0, [node("root"), node("more", depth=1)])

    assert [0, 1] == [tick.shape for tick in tree.ticks]
    assert [1, 2] == [len(shape) for shape in tree.shapes]


def test_a_queue_is_for_the_robots_that_hold_the_dock(waiting):
    log = waiting[3]

    assert {("eve", 20_000_000_000): ("wall_e",)} == log.queues


def test_a_controller_that_runs_away_is_shown_from_its_beginning(check, monkeypatch):
    monkeypatch.setattr(run_log, "MAX_LINES", 5)
    _, log = run_logged(check, Case(), Wanted())

    assert 5 == len(log.lines)
    assert 5 < len(log.happenings)


@pytest.fixture
def followed():
    """Return a log and the simulation that it follows."""
    log = RunLog()
    return log, simulate(watchers=log.watch)


def test_a_rejected_goal_changes_nothing(followed):
    log, run = followed
    run((0.0, go(3.0)), (100.0, go(5.0, goal_id=B, robot="nobody")), until=120.0)

    assert log.lines[-1].text.startswith("navigate_to_pose rejected")
    assert (4.0, 100.0) == (log.changed_until, log.quiet_from)


def test_a_deleted_item_is_gone(followed):
    log, run = followed
    run(until=3.0)
    run.ask("delete_entity", {"entity": "parcel"})

    assert [(0.0, (9.0, 2.3)), (3.0, None)] == [(each.at, each.value) for each in log.changes("item")["parcel"]]


def test_a_spawned_robot_is_there_from_its_spawn_until_its_deletion(followed):
    log, run = followed
    run(until=3.0)
    run.ask("spawn_entity", {"name": "bob", "uri": "robot_type:nurse", "initial_pose": at(3, 2)})
    run(until=5.0)
    run.ask("delete_entity", {"entity": "bob"})

    gone = {name: [(each.at, each.value) for each in changes] for name, changes in log.changes("gone").items()}
    assert {"wall_e": [(0.0, False)], "bob": [(3.0, False), (5.0, True)]} == {
        name: gone[name] for name in ("wall_e", "bob")
    }


def test_the_robots_of_an_earlier_world_are_gone(followed):
    log, run = followed
    run(until=3.0)
    other = {"name": "other", "robots": {"eve": {"at": [0, 0]}, "bob": {"at": [5, 0]}}}
    run.ask("load_world", {"resource_string": json.dumps(other)})

    gone = {name: [each.value for each in changes] for name, changes in log.changes("gone").items()}
    assert {"wall_e": [False, True], "eve": [False], "cart": [False, True], "bob": [False]} == gone
