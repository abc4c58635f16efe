"""The page while simulators start and stop, and with malicious input."""

from __future__ import annotations

import urllib.error
import urllib.request
from urllib.parse import urlsplit

import pytest
import yaml
from playwright.sync_api import expect

from benchmarks._browser import shown, until

YELLOW = "#f5c400"
HOME = [515, 80]
_STATE = "(state) => document.documentElement.dataset.state === state"
_PLAYING, _PAUSED = 1, 2
_POSE = "hmrsim.model.robots.get('wall_e').poseAt(hmrsim.clock.now())"


def test_the_page_reports_the_end_of_a_simulator_and_shows_its_successor(start, ask, open_page, coloured):
    first = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0")
    endpoint = first.ready["endpoints"][0]
    page = open_page(start("view", "--connect", endpoint, "--port", 0).ready["url"])
    until(page, _STATE, "live")

    first.end()
    until(page, _STATE, "lost")
    start("run", "scenario1", "--listen", endpoint, "--robot", "eve@230,80")
    until(page, _STATE, "live")
    until(page, "hmrsim.model.robots.has('eve')")
    until(page, "document.body.dataset.gone === 'false' && !document.getAnimations().length")

    assert coloured(page, [230, 80], YELLOW) > 20
    simulator = ask(endpoint)
    goal = simulator.send("eve", "navigate_to_pose", pose={"pose": {"position": {"x": 230, "y": 300}}})
    assert simulator.result("eve", "navigate_to_pose", goal) == 4
    until(page, "Math.abs(hmrsim.model.robots.get('eve').poseAt(hmrsim.clock.now())[1] - 300) < 0.01")
    assert coloured(page, [230, 80], YELLOW) == 0


def test_time_follows_pause_step_and_speed(viewed, ask, open_page):
    endpoint, url = viewed("scenario1")
    simulator, page = ask(endpoint), open_page(url)

    page.evaluate("hmrsim.commands.pause()")
    until(page, "hmrsim.clock.paused")
    before = simulator.scene()["stamp"]
    assert before == simulator.scene()["stamp"]
    # It glides to where time has stopped.
    stopped = before["sec"] + before["nanosec"] / 1e9
    until(page, "(stopped) => Math.abs(hmrsim.clock.now() - stopped) < 1e-6", stopped)

    page.evaluate("hmrsim.commands.step(5)")
    until(page, "(before) => hmrsim.clock.now() > before", stopped)
    assert simulator.scene()["stamp"] != before

    page.evaluate("hmrsim.commands.resume()")
    until(page, "!hmrsim.clock.paused")
    page.evaluate("hmrsim.commands.setSpeed(20)")
    until(page, "hmrsim.clock.factor === 20")


def test_changes_by_other_clients_are_shown(viewed, ask, open_page):
    endpoint, url = viewed("scenario1")
    simulator, page = ask(endpoint), open_page(url)

    simulator.call(
        "spawn_entity", name="eve", uri="robot_type:carrier", initial_pose={"pose": {"position": {"x": 230, "y": 80}}}
    )
    until(page, "hmrsim.model.robots.has('eve')")
    simulator.call("inject_fault", type="lane_closed", name="party", lane=["lobby", "crossing"])
    until(page, "hmrsim.model.closedLanes.size > 0 && hmrsim.model.faults.has('party')")
    simulator.call("clear_fault", name="party")
    until(page, "hmrsim.model.closedLanes.size === 0 && !hmrsim.model.faults.has('party')")
    simulator.call("delete_entity", entity="eve")
    until(page, "!hmrsim.model.robots.has('eve')")


def test_a_running_simulation_is_rewound_and_returns_to_the_present(viewed, ask, open_page):
    endpoint, url = viewed("scenario1", "--real-time-factor", "5")
    simulator, page = ask(endpoint), open_page(f"{url}?follow=wall_e")
    home = page.evaluate(_POSE)
    go = page.get_by_role("button", name="Go to", exact=True)
    assert 4 == simulator.do("wall_e", "navigate_to_pose", pose={"pose": {"position": {"x": 400, "y": 300}}})
    until(page, "[...hmrsim.model.goals.values()].some((goal) => goal.status === 4)")
    there = page.evaluate(_POSE)

    go.click()
    page.get_by_label("Time of the simulation").fill("0")
    until(page, "document.body.dataset.past === 'true'")
    assert (home, 0) == (page.evaluate(_POSE), page.evaluate("hmrsim.model.goals.size"))
    expect(go).to_be_disabled()
    expect(page.locator("#map")).not_to_have_class("aiming")
    expect(page.locator(".achieved")).to_contain_text("ago")

    page.get_by_label("Speed").select_option("20")
    page.keyboard.press("Space")
    until(page, "hmrsim.model.goals.size === 1")
    assert page.evaluate("!hmrsim.clock.paused")
    page.get_by_role("button", name="Live").click()
    until(page, "document.body.dataset.past === 'false'")
    assert there == page.evaluate(_POSE)
    expect(go).to_be_enabled()


def test_a_page_shows_the_effects_of_another_pages_commands(viewed, open_page):
    _, url = viewed("scenario1")
    one, other = open_page(url), open_page(f"{url}?theme=dark")

    one.evaluate("hmrsim.commands.goTo('wall_e', [400, 300])")

    until(other, "[...hmrsim.model.goals.values()].some((goal) => goal.status > 3)")
    until(other, "hmrsim.model.robots.get('wall_e').poseAt(hmrsim.clock.now())[1] > 299.9")
    assert [["navigate_to_pose", 4]] == other.evaluate(
        "[...hmrsim.model.goals.values()].map((goal) => [goal.action, goal.status])"
    )


def test_markup_in_names_errors_and_events_is_shown_as_text(viewed, ask, open_page, tmp_path):
    evil = "<img src=x onerror='document.title=1'>"
    world = {
        "name": evil,
        "waypoints": {evil: [0, 0], "b": [10, 0]},
        "lanes": [[evil, "b"]],
        "places": {f"place {evil}": {"at": [5, 5]}},
        "docks": {f"dock {evil}": {"at": [0, 5], "type": f"type {evil}"}},
        "items": {f"item {evil}": {"at": [3, 3]}},
        "robot_types": {evil: {"components": {"claw": {"reach": 50}}}},
        "robots": {"wall_e": {"at": [0, 0], "type": evil}},
        "demand": [{"name": "food", "at": evil, "to": f"place {evil}", "arrives": 1}],
    }
    file = tmp_path / "evil.yaml"
    file.write_text(yaml.safe_dump(world))
    endpoint, url = viewed(file)
    simulator, page = ask(endpoint), open_page(f"{url}?follow=wall_e&panel=goals")

    simulator.do("wall_e", "pickup", target_name=f"no {evil}")
    simulator.call("inject_fault", type="breakdown", name="<img src=x>", robot="wall_e")

    until(page, "[...hmrsim.model.goals.values()].some((goal) => goal.status === 6)")
    until(page, "hmrsim.model.faults.has('<img src=x>')")
    for panel in ("goals", "orders", "events", "trees", "charts"):
        shown(page, f"{url}?panel={panel}&follow=wall_e")
        assert 0 == page.locator("img[src=x]").count()
    assert page.title() != "1"
    assert evil in page.evaluate("document.documentElement.textContent + document.title")


_UNREADABLE = [
    {"kind": "battery_empty", "robot": "wall_e", "at": 5},
    {"kind": "deadlock", "robots": 5},
    {"kind": "motion", "robot": "wall_e", "from": 3, "to": 5, "duration": 1},
    {"kind": "waiting", "robot": "wall_e", "for": "eve"},
    {"kind": "waiting", "robot": "wall_e", "for": [{}]},
    {"kind": "status", "robot": "wall_e", "goal_id": "x", "status": 2},
    {"kind": "lane_closed", "lane": 5},
    {"kind": "order_delivered", "order": "x_1", "item": "x", "lead_time": "long"},
    {"kind": {}},
]
_STRANGE = [
    {"kind": "lane_opened", "lane": None},
    {"kind": "__proto__"},
    {"kind": "constructor", "robot": "wall_e"},
    {"kind": "status", "robot": "wall_e", "action": "__proto__", "goal_id": "y", "status": 2},
    {"kind": "fault_began", "name": "strange", "fault": "__proto__", "robot": "wall_e"},
    {"kind": "goal", "robot": "wall_e", "action": "wait", "goal_id": "z", "goal": {"time": 5}},
    {"kind": "door_closed", "door": "nowhere", "at": "noon"},
    {"kind": "order_picked_up", "order": "__proto__", "item": "x"},
]


@pytest.mark.parametrize("panel", ["goals", "orders", "events", "charts", "trees"])
def test_invalid_events_are_skipped_with_a_notice(viewed, ask, open_page, panel):
    endpoint, url = viewed("scenario1")
    simulator = ask(endpoint)
    page = open_page(f"{url}?panel={panel}&follow=wall_e", unreadable=len(_UNREADABLE))

    for event in [*_UNREADABLE, *_STRANGE]:
        simulator.tell(**event)
    simulator.call("inject_fault", type="breakdown", name="after", robot="wall_e")

    until(page, "hmrsim.model.faults.has('after')")
    until(page, "document.querySelector('.toasts').textContent.includes(\"can't be read\")")
    until(page, "document.querySelector('.inspector').textContent.includes('broken down')")
    page.evaluate("window.seen = hmrsim.map.stats.frames; hmrsim.map.changed(true)")
    until(page, "hmrsim.map.stats.frames > window.seen")
    assert 0 == page.locator("[data-failed]").count()


def test_a_part_that_fails_to_render_leaves_the_others(viewed, open_page):
    _, url = viewed("scenario1")
    page = open_page(f"{url}?panel=goals")
    page.evaluate("""() => {
      console.error = () => {};
      window.goals = hmrsim.model.goals;
      Object.defineProperty(hmrsim.model, 'goals', {get() { throw new Error('no goals'); }, configurable: true});
    }""")

    until(page, "document.querySelector('.side').dataset.failed === 'true'")
    shown_then = page.evaluate("hmrsim.clock.now()")
    until(page, "(then) => hmrsim.clock.now() > then + 0.5", shown_then)
    until(page, "(then) => document.querySelector('.time').textContent > then", page.locator(".time").text_content())
    page.evaluate("Object.defineProperty(hmrsim.model, 'goals', {value: window.goals, writable: true})")
    until(page, "document.querySelector('.side').dataset.failed === undefined")


def test_beyond_the_loopback_the_page_requires_its_token(start, open_page):
    simulator = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0")
    url = start("view", "--connect", simulator.ready["endpoints"][0], "--host", "0.0.0.0", "--port", 0).ready["url"]
    parts = urlsplit(url)

    page = open_page(url)

    until(page, _STATE, "live")
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(f"http://{parts.netloc}/")


def test_without_a_gpu_the_map_is_drawn_by_the_processor(viewed, open_page):
    """A browser that emulates a GPU takes several times as long to draw a canvas as one that knows that it has none."""
    _, url = viewed("scenario1")
    page = open_page(url)

    attributes = "(name) => document.querySelector(name).getContext('2d').getContextAttributes().willReadFrequently"
    assert [True, True] == [page.evaluate(attributes, name) for name in (".map-still", ".map-moving")]


def test_a_page_of_another_origin_gets_no_websocket(viewed, browser):
    _, url = viewed("scenario1")
    stranger = browser.new_context().new_page()
    stranger.goto("data:text/html,<p>another site")

    opened = stranger.evaluate(
        """(url) => new Promise((then) => {
          const socket = new WebSocket(url);
          socket.onopen = () => then('open');
          socket.onerror = () => then('refused');
        })""",
        f"ws://{urlsplit(url).netloc}/ws",
    )

    assert opened == "refused"
    stranger.context.close()


def test_only_the_welcome_has_a_button_that_ends_it(viewed, open_page):
    _, url = viewed("scenario1")
    page = open_page(url)
    hint = page.locator(".hint")

    expect(hint.get_by_label("Got it")).to_be_visible()
    page.keyboard.press("n")
    page.keyboard.press("m")
    expect(hint).to_contain_text("Click where wall_e should go")
    expect(hint.get_by_label("Got it")).to_be_hidden()


def test_the_welcome_covers_no_name_that_the_search_finds(viewed, open_page):
    _, url = viewed("scenario1")
    page = open_page(url)
    expect(page.locator(".hint")).to_be_visible()

    page.get_by_role("combobox", name="Find a robot").fill("wall")
    page.get_by_role("option").first.locator(".icon").click()

    until(page, "hmrsim.map.selected === 'wall_e'")
