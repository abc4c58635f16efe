"""The page of a failing run."""

from __future__ import annotations

import json
import math
import re

from hmrsim.fault_search.failure_page import code_in, failure_page, run_logged, title_of
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.run_page import Heading, RunLog, ShownRun, page_of
from tests.porters import WORLD, check_of
from tests.simulation import go, simulate
from tests.unit.hmrsim.run_page.conftest import BREAKDOWN

SLOW = Injection({"change": {"robots.other.base.speed": 0.5}})


def data_of(page):
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    return json.loads(text)


def test_the_page_has_the_failing_run_and_the_passing_one(page):
    data = data_of(page)

    assert ["violated"] == [kind for kind in ("violated", "passing") if f'<li class="{kind}">' in page]
    assert [1, 0] == [len(run["violations"]) for run in data["runs"]]
    assert ["porter", "other"] == [robot["name"] for robot in data["runs"][0]["robots"]]
    assert 10.0 == data["difference"]["at"]
    assert "breakdown of porter for 60 s, when pickup of porter is executing" in page
    assert "it passes: the run ends as succeeded at " in page


def test_the_same_runs_give_the_same_page(check, page):
    outcome, log = run_logged(check, Case((BREAKDOWN,)), Wanted())

    assert page == failure_page(check, Case((BREAKDOWN,)), outcome, log)


def test_the_run_beside_it_lacks_the_last_element_without_which_it_passes(check):
    case = Case((SLOW, BREAKDOWN))
    page = failure_page(check, case, *run_logged(check, case, Wanted()))

    assert "without breakdown of porter for 60 s" in page
    assert 2 == len(data_of(page)["runs"])


def test_the_title_says_what_happened_and_the_line_above_it_which_property_that_violates(page):
    assert "<h1>The same goal of porter/pickup was rejected 5 times in a row" in page
    assert '<p class="kind">Failing run of porters: violates no_vain_goals</p>' in page


def test_the_title_of_a_long_text_is_its_first_part():
    details = "no task is ready, " * 10

    assert ("The controller is in a deadlock", details) == title_of(f"the controller is in a deadlock: {details}")
    assert ("wall_e: is late", "") == title_of("wall_e: is late")


def test_the_goal_that_a_fault_aborts_is_named_as_it_may_be_a_later_one():
    """The first goal ends as soon as it begins, as the robot is there."""
    check = check_of("crashing", world={**WORLD, "robots": {"porter": {"at": "store", "components": {"claw": {}}}}})
    aborted = {"type": "goals_aborted", "robot": "porter", "action": "navigate_to_pose", "count": 1}
    anchor = {"goal": "executing", "robot": "porter", "action": "navigate_to_pose"}
    case = Case((Injection({**aborted, "when": anchor}),))
    page = failure_page(check, case, *run_logged(check, case, Wanted()))

    assert "the 1st navigate_to_pose of porter is aborted; this hits porter navigate_to_pose: shelf, at 0.000 s" in page


def test_a_run_that_fails_without_any_fault_stands_alone():
    check = check_of("broken")
    page = failure_page(check, Case(), *run_logged(check, Case(), Wanted()))

    assert "The run fails without any fault, so there is no passing run beside it." in page
    assert 1 == len(data_of(page)["runs"])


def test_the_lines_at_which_tasks_wait_are_quoted(tmp_path):
    source = tmp_path / "mission.py"
    source.write_text("first = 1\nawait gate.wait()\n", encoding="utf-8")

    assert [(f"{source}:2", "await gate.wait()")] == [*code_in(f"eve ({source}:2); ben ({source}:2); ada (gone.py:1)")]


def test_an_instant_goal_at_the_end_of_a_run_can_be_seen(page):
    (x, width), *_ = re.findall(r'class="g aborted mark" x="([\d.]+)" y="2" width="([\d.]+)"', page)

    assert 20.0 > float(width)
    assert float(x) <= 9_980


def test_names_of_a_sparse_world_are_clear_of_robots_at_their_points(page):
    point = re.search(r'<circle cx="([\d.]+)" cy="([\d.]+)"[^>]*><title>store<', page)
    name = re.search(r'<text x="([\d.]+)" y="([\d.]+)"[^>]*>store<', page)
    radius = float(re.search(r'class="ring" r="([\d.]+)"', page)[1]) / 1.3

    assert radius < math.dist([float(each) for each in point.groups()], [float(each) for each in name.groups()])


def test_the_map_has_the_segments_that_robots_drive_off_the_lanes(page):
    log = RunLog()
    simulate(watchers=log.watch)((0.0, go(3.0)), until=10.0)
    open_space = page_of(Heading("Run", "A run", "", ""), (), (ShownRun("The run", log, "ended", 10.0),))

    assert 1 == open_space.count("<title>driven off the lanes</title>")
    assert "driven off the lanes" not in page


def test_a_reduced_world_is_named():
    check = check_of("vain")
    world = {**check.definition, "robots": {"porter": check.definition["robots"]["porter"]}}
    case = Case((BREAKDOWN,), world)
    page = failure_page(check, case, *run_logged(check, case, Wanted()))

    assert "The search has left out 1 of 2 robots (other)." in page


def test_the_whole_world_is_not_called_reduced(page):
    assert "The world is reduced" not in page


def test_names_can_not_end_the_data():
    world = {**WORLD, "waypoints": {**WORLD["waypoints"], "</script><b>": [5, 5]}}
    check = check_of("careful", world=world)
    case = Case((Injection({"type": "goals_aborted", "robot": "porter", "name": "</script>", "at": 0.0, "count": 1}),))
    page = failure_page(check, case, *run_logged(check, case, Wanted()))

    assert "</script><b>" not in page
    assert any("</script>" in text for _, _, text, _ in data_of(page)["runs"][0]["lines"])


def test_the_page_needs_nothing_else(page):
    assert not re.findall(r'(?:src|href)="(?!#)', page)
    assert "default-src 'none'" in page


def test_the_time_axis_leaves_out_a_long_wait(waiting):
    check, case, outcome, log = waiting
    page = failure_page(check, case, outcome, log)

    assert data_of(page)["length"] < 100
    assert "until the end at 600.0 s, which the time axis leaves out." in page
