"""The page of a failing run, opened from disk."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest

from benchmarks._browser import until
from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.failure_page import failure_page, run_logged
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.run_page.comparison import Heading, ShownRun
from hmrsim.run_page.run_log import RunLog
from hmrsim.run_page.writer import page_of
from tests.simulation import B, at, go, simulate

_TREE = '''"""A waiter that goes on when driving has failed."""

from py_trees.composites import Sequence
from py_trees.decorators import FailureIsSuccess

from bt_controller.behaviours.robot_actions import GoTo, Pickup, Place


def serve(robot):
    drive = FailureIsSuccess("Drive", GoTo("table_1"))
    return Sequence(robot, memory=True, children=[GoTo("counter"), Pickup("coffee"), drive, Place("coffee")])
'''
_PROPERTY = {"never": {"all": [{"event": "placed"}, {"not": {"item": "coffee", "at": "table_1"}}]}}
_REJECTED = {"type": "goals_rejected", "robot": "mocha", "action": "navigate_to_pose", "count": 1, "at": 1.0}
NOTHING = "\N{EN DASH}"
_PLACES = "() => [...document.querySelectorAll('[data-robot=mocha]')].map((each) => each.getAttribute('transform'))"


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    """Return the page of a waiter that puts the coffee down where it was picked up."""
    folder = tmp_path_factory.mktemp("run_page")
    (folder / "hasty.py").write_text(_TREE, encoding="utf-8")
    controller = {"tree": "hasty.py:serve", "robots": ["mocha"]}
    said = {"world": "cafe", "controller": controller, "properties": {"properties": {"right_table": _PROPERTY}}}
    check = check_at(CheckFile.model_validate(said), folder)
    case = Case((Injection(_REJECTED),))
    file = folder / "failure.html"
    file.write_text(failure_page(check, case, *run_logged(check, case, Wanted())), encoding="utf-8")
    return file


@pytest.fixture
def page(page_file, open_page):
    return open_page(page_file.as_uri())


def to(page, seconds):
    page.evaluate(
        "(at) => { const time = document.getElementById('time'); time.value = at;"
        " time.dispatchEvent(new Event('input')); }",
        seconds,
    )


def test_the_slider_moves_the_robots_of_both_runs(page):
    to(page, 0)
    start = page.evaluate(_PLACES)
    to(page, 2)
    between = page.evaluate(_PLACES)
    to(page, 9)
    end = page.evaluate(_PLACES)

    assert start[0] == start[1]
    assert between[0] == between[1] != start[0]
    assert end[0] != end[1]


def test_it_opens_at_the_first_difference_and_jumps_back_to_it(page):
    there = page.text_content("#clock")
    assert "rejected" in page.text_content(".events .difference")
    to(page, 0)
    page.click("#difference")

    assert page.text_content("#clock") == there
    assert ["navigate_to_pose rejected", "navigate_to_pose accepted"] == [
        " ".join(item.split()[1:3]).removesuffix(":") for item in page.locator(".events .now span").all_inner_texts()
    ]


def test_the_trees_at_the_first_difference_have_reacted_to_it(page):
    page.click("#difference")

    assert 0 < page.locator(".tree .differs").count()


def test_the_tree_is_shown_as_it_was_ticked(page):
    to(page, 1)
    assert ["R", "R"] == page.eval_on_selector_all(".tree li:nth-child(2)", "(all) => all.map((li) => li.dataset.is)")
    to(page, 9)

    assert 0 < page.locator(".tree .differs").count()


def test_the_keyboard_moves_the_slider_and_steps_through_events(page):
    to(page, 0)
    page.focus("#time")
    page.keyboard.press("ArrowRight")
    assert page.text_content("#clock").startswith("0.100 s")
    page.keyboard.press("n")
    page.keyboard.press("p")

    assert "true" == page.evaluate("String(document.querySelector('.events .now') !== null)")


def test_stepping_goes_on_from_the_time_of_the_slider(page):
    to(page, 2)
    page.click("#next")

    assert float(page.input_value("#time")) > 2


def test_each_step_changes_the_text_beside_the_buttons(page):
    texts = page.evaluate("() => stops.map((stop, i) => { showStop(i); return clock.textContent; })")

    assert len(texts) == len(set(texts))
    assert texts[0].split("event ")[1].startswith("0 of ")


def test_stepping_reaches_each_row_of_both_runs_in_order(page):
    steps = page.evaluate(
        "() => { show(0, 0);"
        " return stops.map(() => { const now = [cursor.at, ...cursor.counts]; step(1); return now; }); }"
    )

    assert steps == sorted(steps)
    assert all(one <= other for pair in pairwise(steps) for one, other in zip(*pair, strict=True))
    assert steps[-1][1:] == page.evaluate("runs.map((run) => run.items.length)")
    assert "violated" in page.get_attribute(".events[data-run='0'] .now", "class")


def test_the_table_follows_the_selected_event_within_an_instant(page):
    picked = page.locator(".events[data-run='1'] li", has_text="picks up coffee")
    held = "[data-run='1'] .now td:nth-child(4)"
    picked.click()
    assert page.text_content(held) == "coffee"
    page.click("#previous")
    assert page.text_content(held) == NOTHING


def test_the_end_shows_what_the_last_events_have_changed(page):
    page.evaluate("show(data.length)")

    assert page.text_content("[data-run='1'] .now td:nth-child(4)") == NOTHING
    assert page.locator(".events .later").count() == 0


def test_trees_do_not_differ_before_the_runs_do(page):
    differing = page.evaluate(
        "() => stops.slice(0, stops.difference).map((stop, i) => {"
        " showStop(i); return document.querySelectorAll('.tree .differs').length; })"
    )

    assert 1 < len(differing)
    assert not any(differing)


def test_trees_do_not_run_ahead_of_the_events_of_an_instant(page):
    placed, shown = page.evaluate(
        "() => [runs[0].items.findIndex(({ element }) => element.textContent.includes('place SUCCEEDED')),"
        " stops.map((stop, i) => i).filter((i) => i >= stops.difference).map((i) => { showStop(i);"
        " return [stops[i].counts[0], document.querySelector('.tree li:last-child').dataset.is]; })]"
    )

    assert {"R", "S"} <= {status for _, status in shown}
    assert all((status == "S") == (placed < count) for count, status in shown)


def test_a_violation_in_the_key_moments_selects_its_row(page):
    page.click(".moments .violated .jump")

    assert "violated" in page.get_attribute(".events[data-run='0'] .now", "class")


def test_a_click_on_a_time_marks_it_and_brings_a_map_into_view(page):
    cause = page.locator(".moments .cause .jump")
    cause.click()

    assert ["true"] == page.eval_on_selector_all(".jump[aria-current]", "(all) => all.map((each) => each.ariaCurrent)")
    assert "true" == cause.get_attribute("aria-current")
    top, bottom = page.evaluate(
        "() => { const map = document.querySelector('.map').getBoundingClientRect(); return [map.top, map.bottom]; }"
    )
    assert 0 <= top < bottom <= 800


def test_stepping_marks_the_time_of_the_event_that_is_shown(page):
    page.click("#difference")
    assert page.is_visible(".moments .difference [aria-current]")
    page.keyboard.press("p")
    assert 0 == page.locator(".moments .difference [aria-current]").count()


def test_the_time_is_visible_wherever_the_page_is_scrolled_to(page):
    for height in (0, 400, 10_000):
        page.evaluate("(height) => scrollTo(0, height)", height)
        assert page.evaluate(
            "(() => { const box = slider.getBoundingClientRect();"
            " return 0 <= box.top && box.bottom <= innerHeight; })()"
        )


def test_it_plays(page):
    to(page, 0)
    page.keyboard.press(" ")
    until(page, "Number(document.getElementById('time').value) > 0.2")
    page.keyboard.press(" ")

    assert page.get_attribute("#play", "aria-pressed") == "false"


def test_keys_work_after_a_click_on_a_button(page):
    page.click(".moments .violated .jump")
    page.keyboard.press("d")
    difference = page.evaluate("cursor.stop")
    page.keyboard.press("n")
    stepped = page.evaluate("cursor.stop")
    page.keyboard.press("p")
    assert [difference + 1, difference] == [stepped, page.evaluate("cursor.stop")]
    page.keyboard.press(" ")

    assert page.get_attribute("#play", "aria-pressed") == "true"


def test_space_plays_once_after_a_click_on_play(page):
    page.click("#play")
    page.keyboard.press(" ")

    assert page.get_attribute("#play", "aria-pressed") == "false"


def test_a_click_on_the_chart_shows_that_time(page):
    track = page.locator(".chart .row .track").first
    box = track.bounding_box()
    track.click(position={"x": box["width"] / 2, "y": 4})

    half = float(page.get_attribute("#time", "max")) / 2
    assert half == pytest.approx(float(page.input_value("#time")), abs=0.1)


def test_maps_and_time_are_on_the_first_screen(page_file, open_page):
    page = open_page(page_file.as_uri(), viewport={"width": 1440, "height": 900})

    bottoms = page.eval_on_selector_all(".map, .time", "(all) => all.map((e) => e.getBoundingClientRect().bottom)")
    assert max(bottoms) <= 900


def test_it_fits_a_phone(page_file, open_page):
    page = open_page(page_file.as_uri(), viewport={"width": 390, "height": 800})

    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_print_has_the_maps_and_the_events_near_the_moment_but_no_buttons(page):
    page.emulate_media(media="print")

    assert not page.is_visible("#play")
    assert page.is_visible("[data-run='0'] .map svg")
    events = page.locator(".events[data-run='0'] li")
    printed = events.locator("visible=true").count()
    assert 0 < printed <= 24
    first, last, total = map(int, re.findall(r"\d+", page.text_content(".shown[data-run='0']"))[:3])
    assert (printed, events.count()) == (last - first + 1, total)


@pytest.fixture
def shown(tmp_path, open_page):
    """Return the function that opens the page of a log."""

    def load(log, seconds):
        file = tmp_path / "run.html"
        run = ShownRun("The run", log, "ended", seconds)
        file.write_text(page_of(Heading("Run", "A run", "", ""), (), (run,)), encoding="utf-8")
        return open_page(file.as_uri())

    return load


def test_events_after_the_end_of_the_time_axis_are_shown(shown):
    log = RunLog()
    run = simulate(watchers=log.watch)
    run((0.0, go(3.0)), (100.0, go(5.0, goal_id=B, robot="nobody")), until=120.0)
    page = shown(log, 120.0)
    page.click(".events li:last-child")

    assert float(page.get_attribute("#time", "max")) < 20
    assert page.text_content("#clock").startswith("100.000 s of 120.000 s")
    assert page.evaluate("line.offsetLeft <= chart.clientWidth")


def test_robots_and_items_are_on_the_map_only_while_they_exist(shown):
    log = RunLog()
    run = simulate(watchers=log.watch)
    run(until=3.0)
    run.ask("spawn_entity", {"name": "bob", "uri": "robot_type:nurse", "initial_pose": at(3, 2)})
    run.ask("delete_entity", {"entity": "parcel"})
    run(until=5.0)
    page = shown(log, 5.0)

    visible = []
    for seconds in (1, 4):
        to(page, seconds)
        visible.append([page.is_visible(each) for each in ("[data-robot=bob]", "[data-item=parcel]")])
    assert [[False, True], [True, False]] == visible
