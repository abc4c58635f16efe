"""Further work with the page: finding robots, filling in forms, reading the log."""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import expect

from benchmarks._browser import until

SUCCEEDED, ABORTED = 4, 6


@pytest.fixture
def hospital(viewed, ask, open_page):
    """Return a client of the hospital world, and a function that opens its page."""
    endpoint, url = viewed("hospital", "--real-time-factor", "20")
    return ask(endpoint), lambda query="", **context: open_page(f"{url}{query}", **context)


def test_the_list_of_robots_filters_and_follows(hospital):
    _, show = hospital
    page = show("?panel=robots")

    rows = page.get_by_role("list", name="Robots").get_by_role("button")
    assert 8 == rows.count()
    page.get_by_label("Filter robots").fill("charger_2")
    expect(rows).to_have_count(1)
    rows.first.click()

    until(page, "hmrsim.map.follow === 'eve' && hmrsim.map.selected === 'eve'")
    expect(rows.first).to_contain_text("idle")
    expect(rows.first).to_contain_text("100 %")


def test_robots_that_need_attention_are_sorted_first(hospital):
    simulator, show = hospital
    simulator.call("inject_fault", type="breakdown", robot="vaq_m")
    page = show("?panel=robots")

    page.get_by_label("Sort robots by").select_option("State")

    expect(page.get_by_role("list", name="Robots").get_by_role("button").first).to_contain_text("vaq_m")


def test_a_form_proposes_values_and_stays_open_after_an_error(hospital):
    simulator, show = hospital
    page = show("?panel=goals&follow=wall_e")

    page.keyboard.press("a")
    page.get_by_role("combobox", name="Action").select_option("Pick up")
    page.get_by_role("dialog").get_by_role("combobox", name="Item").select_option("medicine")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.get_by_role("dialog").get_by_role("alert").filter(has_text="out of reach")).to_be_visible()
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    until(page, "(status) => [...hmrsim.model.goals.values()].some((goal) => goal.status === status)", ABORTED)

    x, y = page.evaluate("hmrsim.model.world.point('pharmacy')")
    assert SUCCEEDED == simulator.do("wall_e", "navigate_to_pose", pose={"pose": {"position": {"x": x, "y": y}}})
    page.keyboard.press("a")
    page.get_by_role("combobox", name="Action").select_option("Pick up")
    page.get_by_role("dialog").get_by_role("combobox", name="Item").select_option("medicine")
    page.get_by_role("button", name="Send", exact=True).click()

    # Toasts go by themselves.
    expect(page.locator(".toasts")).to_contain_text("wall_e: Pick up accepted.")
    until(page, "hmrsim.model.robots.get('wall_e').holds.includes('medicine')")


def test_invalid_fields_are_reported_before_sending(hospital):
    simulator, show = hospital
    page = show("?follow=eve")

    page.keyboard.press("a")
    page.get_by_role("combobox", name="Action").select_option("Back up")
    distance = page.get_by_label("Distance, m")
    distance.fill("-2")
    page.get_by_role("button", name="Send", exact=True).click()

    expect(page.get_by_text("Give at least 0.")).to_be_visible()
    expect(distance).to_be_focused()
    assert [] == simulator.robot("eve")["goals"]


def test_the_form_of_a_fault_has_units_and_defaults(hospital):
    simulator, show = hospital
    page = show("?follow=eve")

    page.get_by_role("button", name="Fault…").click()
    page.get_by_role("combobox", name="Fault").select_option("Wheel slip")
    page.get_by_label("Duration, s (optional)", exact=True).fill("1000")
    page.get_by_role("button", name="Inject", exact=True).click()

    until(page, "[...hmrsim.model.faults.values()].some(({ fault, robot }) => fault === 'slip' && robot === 'eve')")
    # The hospital's world defines faults, such as a wet floor.
    (slip,) = (one for one in simulator.scene()["faults"] if (one["fault"], one.get("robot")) == ("slip", "eve"))
    assert 0.5 == slip["factor"]


def test_events_from_before_the_page_are_shown(hospital):
    simulator, show = hospital
    simulator.do("eve", "wait", time={"sec": 2})

    page = show("?panel=events")

    expect(page.get_by_role("list", name="Events")).to_contain_text("wait SUCCEEDED")
    lasted = "(([goal]) => goal.ended - goal.accepted)([...hmrsim.model.goals.values()])"
    assert 2.0 == pytest.approx(page.evaluate(lasted))


def test_a_long_name_of_an_event_stays_in_its_row(hospital):
    """The names of a lane's two waypoints would cover the neighboring rows."""
    simulator, show = hospital
    simulator.call("inject_fault", type="lane_closed", lane=["pharmacy_counter", "pharmacy_door"])

    page = show("?panel=events")
    name = page.get_by_role("list", name="Events").locator(".name", has_text="pharmacy_counter").first

    assert name.bounding_box()["height"] < 1.7 * float(name.evaluate("e => parseFloat(getComputedStyle(e).fontSize)"))


def test_an_unreachable_goal_shows_only_its_reason(hospital):
    _, show = hospital
    page = show("?follow=wall_e")

    page.evaluate("""async () => {
      const {Orders} = await import('/orders.js');
      const toasts = {said: [], show(kind, text, more) { this.said.push([kind, text, more]); }};
      const patience = {sent: 3e5, shown: 3e5, begun: 3e5};
      const orders = new Orders({...hmrsim, toasts, aim() {}, map: hmrsim.map}, patience);
      orders.sendToPoint('wall_e', {kind: 'floor', name: '', point: [1e6, 1e6]});
      window.said = toasts.said;
    }""")
    until(page, "said.length > 0")

    ((kind, text, more),) = page.evaluate("said")
    assert ("error", "Could not send wall_e to 1000000.0, 1000000.0") == (kind, text)
    assert "outside" in more, json.dumps(more)


@pytest.mark.parametrize(("role", "focus"), [("button", "Robots"), ("button", "Step"), ("combobox", "Sort robots by")])
def test_space_pauses_whatever_has_the_focus(hospital, role, focus):
    _, show = hospital
    page = show("?panel=robots")
    control = page.get_by_role(role, name=focus, exact=True)
    # The controls of time are disabled until the page has heard of the simulator.
    expect(control).to_be_enabled()
    control.focus()

    page.keyboard.press("Space")
    until(page, "hmrsim.clock.paused")
    assert control.evaluate("(control) => control === document.activeElement")
    assert "true" == page.get_by_role("button", name="Robots", exact=True).get_attribute("aria-expanded")
    page.keyboard.press("Space")
    until(page, "!hmrsim.clock.paused")


def test_space_types_in_the_search(hospital):
    _, show = hospital
    page = show()

    page.keyboard.press("/")
    page.keyboard.type("ward a")

    expect(page.get_by_role("combobox", name="Find a robot")).to_have_value("ward a")
    assert page.evaluate("!hmrsim.clock.paused")


def test_a_form_shows_only_its_own_errors(hospital):
    """An error goes when the form changes or closes, and a late one does not appear in the next form."""
    _, show = hospital
    page = show("?follow=wall_e")
    page.evaluate("""() => {
      window.answers = [];
      hmrsim.commands.sendGoal = () => new Promise((_, give) => answers.push(give));
    }""")
    dialog = page.get_by_role("dialog")
    error = dialog.locator(".form-error")

    page.keyboard.press("a")
    page.get_by_role("combobox", name="Action").select_option("Undock robot")
    page.get_by_role("button", name="Send", exact=True).click()
    page.evaluate("answers.pop()(new Error('not now'))")
    expect(error).to_have_text("not now")
    page.get_by_role("combobox", name="Action").select_option("Wait")
    expect(error).to_be_hidden()

    page.get_by_role("combobox", name="Action").select_option("Undock robot")
    page.get_by_role("button", name="Send", exact=True).click()
    until(page, "answers.length")
    dialog.get_by_role("button", name="Cancel").click()
    page.keyboard.press("n")
    page.keyboard.press("a")
    expect(dialog).to_be_visible()
    page.evaluate("answers.pop()(new Error('too late'))")
    expect(page.locator(".toasts")).to_contain_text("Send a goal to wall_e: too late")
    expect(error).to_be_hidden()
    expect(page.get_by_role("button", name="Send", exact=True)).to_be_enabled()


def test_the_list_shows_the_fault_of_an_idle_robot(hospital):
    simulator, show = hospital
    page = show("?panel=robots")
    row = page.get_by_role("list", name="Robots").get_by_role("button").filter(has_text="wall_e")
    expect(row).to_contain_text("idle")
    expect(row.locator(".level")).to_be_hidden()

    simulator.call("inject_fault", type="slip", name="wet", robot="wall_e", settings='{"factor": 0.5}')

    expect(row).to_contain_text("wet (slip)")
    expect(row).to_contain_text("idle")
    expect(row.locator(".level")).to_be_visible()


def test_a_visible_robot_is_selected_without_moving_the_map(hospital):
    """The map stays fitted beside the open panel; only a robot out of sight is centered."""
    _, show = hospital
    page = show("?panel=goals")
    until(page, "hmrsim.map.camera.fitted && hmrsim.map.camera.insets.right > 0")
    corner = "hmrsim.map.toScreen(hmrsim.map.camera.box[2], 0)[0]"
    assert page.evaluate(corner) < page.locator(".side").bounding_box()["x"]

    page.keyboard.press("n")
    until(page, "hmrsim.map.selected !== null")
    assert page.evaluate("hmrsim.map.camera.fitted && hmrsim.map.camera.glide === null")

    page.evaluate("hmrsim.map.camera.moveTo({ x: 1e4, y: 1e4, scale: 20 }, false)")
    page.keyboard.press("n")
    until(page, "hmrsim.map.camera.glide !== null || Math.abs(hmrsim.map.camera.x) < 100")


def test_of_a_thousand_robots_only_visible_rows_and_trees_are_laid_out(hospital):
    _, show = hospital
    page = show("?panel=robots")
    page.evaluate("""() => {
      const node = { depth: 0, name: 'root', kind: 'Sequence', symbol: '', status: 'RUNNING', message: '' };
      for (let i = 0; i < 1000; i += 1) {
        hmrsim.model.addRobot(`robot_${i}`);
        hmrsim.model.receive(`robot_${i}/_tree`, { status: 'RUNNING', tick: i, sim_time: 0, nodes: [node] });
      }
    }""")

    until(page, "parseFloat(document.querySelector('.rows-body').style.height) > 1000 * 40")
    assert page.locator(".rows .row").count() < 60
    page.keyboard.press("t")
    until(page, "document.querySelectorAll('.trees > .card').length >= 1000")
    laid_out = """() => [...document.querySelectorAll('.trees summary')]
        .filter((row) => row.checkVisibility({ contentVisibilityAuto: true })).length"""
    assert 3 < page.evaluate(laid_out) < 100
