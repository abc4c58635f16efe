"""Commands from the page to the simulator: with a mouse, a finger or a key."""

from __future__ import annotations

import subprocess
import sys

import pytest
from playwright.sync_api import expect

from benchmarks._browser import until

HOME, ROOM, FAR = [515, 80], [512, 215], [100, 215]
_ENDED = "(status) => [...hmrsim.model.goals.values()].some((goal) => goal.status === status)"
_HERE = "() => hmrsim.model.robots.get('wall_e').poseAt(hmrsim.clock.now()).slice(0, 2)"
SUCCEEDED, CANCELED = 4, 5


def test_clicking_a_robot_and_a_place_sends_it_there(viewed, ask, open_page, on_page):
    endpoint, url = viewed("scenario1")
    simulator, page = ask(endpoint), open_page(f"{url}?panel=goals")

    page.mouse.click(*on_page(page, HOME))
    page.mouse.click(*on_page(page, ROOM))

    until(page, _ENDED, SUCCEEDED)
    assert simulator.robot("wall_e")["pose"][:2] == pytest.approx(ROOM, abs=3)
    (goal,) = simulator.robot("wall_e")["goals"]
    assert (goal["action"], goal["status"]) == ("navigate_to_pose", SUCCEEDED)
    until(page, "document.querySelector('.right').textContent.includes('wall_e')")


def test_the_menu_of_a_robot_cancels_its_goal(viewed, ask, open_page, on_page):
    endpoint, url = viewed("scenario1", "--real-time-factor", "0.05")
    simulator, page = ask(endpoint), open_page(url)
    goal = simulator.send("wall_e", "navigate_to_pose", pose={"pose": {"position": {"x": FAR[0], "y": FAR[1]}}})
    until(page, "hmrsim.model.robots.get('wall_e').motion !== null")

    page.mouse.click(*on_page(page, page.evaluate(_HERE)), button="right")
    page.get_by_role("menuitem", name="Cancel goal").click()

    assert simulator.result("wall_e", "navigate_to_pose", goal) == CANCELED
    until(page, _ENDED, CANCELED)
    assert simulator.robot("wall_e")["motion"] is None


def test_the_menu_of_a_robot_injects_and_clears_a_fault(viewed, ask, open_page, on_page):
    endpoint, url = viewed("scenario1")
    simulator, page = ask(endpoint), open_page(url)

    page.mouse.click(*on_page(page, HOME), button="right")
    page.get_by_role("menuitem", name="Break down").click()
    until(page, "hmrsim.model.robots.get('wall_e').stateAt(hmrsim.clock.now()) === 'stopped'")
    assert ["breakdown"] == [fault["fault"] for fault in simulator.scene()["faults"]]

    page.mouse.click(*on_page(page, HOME), button="right")
    page.get_by_role("menuitem", name="Clear breakdown").click()
    until(page, "hmrsim.model.robots.get('wall_e').stateAt(hmrsim.clock.now()) === 'idle'")
    assert simulator.scene()["faults"] == []


def test_buttons_pause_step_and_change_the_speed(viewed, ask, open_page):
    endpoint, url = viewed("scenario1")
    simulator, page = ask(endpoint), open_page(url)

    page.get_by_role("button", name="Pause").click()
    until(page, "hmrsim.clock.paused")
    before = simulator.scene()["stamp"]
    assert before == simulator.scene()["stamp"]
    page.get_by_role("button", name="Step").click()
    until(page, "(before) => hmrsim.clock.now() > before", before["sec"] + before["nanosec"] / 1e9)
    page.get_by_role("button", name="Resume").click()
    until(page, "!hmrsim.clock.paused")
    page.get_by_label("Speed").select_option("5")
    until(page, "hmrsim.clock.factor === 5")


def test_a_controllers_tree_is_shown_during_and_after_its_run(viewed, open_page):
    endpoint, url = viewed("scenario2")
    page = open_page(f"{url}?panel=trees")
    tree = "bt_controller.examples:go_to_pose"

    words = [sys.executable, "-m", "bt_controller", "run", tree, "--robot", "wall_e", "--connect", endpoint, "--quiet"]
    assert subprocess.run(words, check=False, capture_output=True).returncode == 0

    until(page, "document.querySelector('.right').textContent.includes('GoToPoseAction')")


def test_the_coverage_of_a_tree_is_shown(viewed, open_page, tmp_path):
    endpoint, url = viewed("scenario2")
    page = open_page(f"{url}?panel=trees")
    words = [sys.executable, "-m", "bt_controller", "run", "bt_controller.examples:go_to_pose", "--robot", "wall_e"]
    words += ["--connect", endpoint, "--quiet", "--coverage", str(tmp_path / "seen.json")]
    assert subprocess.run(words, check=False, capture_output=True).returncode == 0

    until(page, "[...document.querySelectorAll('.covered')].some((each) => each.title === 'SUCCESS 1, never failed')")


def test_a_phone_shows_the_page_in_width_and_two_taps_send_a_robot(viewed, open_page, on_page):
    _, url = viewed("scenario1")
    page = open_page(url, viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True, device_scale_factor=2)

    assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")
    small = """() => [...document.querySelectorAll('button')].filter((button) => button.checkVisibility())
        .filter((button) => Math.min(button.offsetWidth, button.offsetHeight) < 24).length"""
    assert page.evaluate(small) == 0
    page.touchscreen.tap(*on_page(page, HOME))
    until(page, "hmrsim.map.selected === 'wall_e' && hmrsim.map.camera.glide === null")
    page.touchscreen.tap(*on_page(page, ROOM))
    until(page, _ENDED, SUCCEEDED)


def test_the_page_can_be_used_with_the_keyboard(viewed, open_page):
    _, url = viewed("hospital")
    page = open_page(f"{url}?theme=light&panel=none")

    page.keyboard.press("/")
    page.keyboard.type("eve")
    page.keyboard.press("Enter")
    until(page, "hmrsim.map.selected === 'eve'")
    page.keyboard.press("Escape")
    page.keyboard.press("d")
    until(page, "document.documentElement.dataset.theme === 'dark'")


def test_a_robot_is_sent_to_the_chosen_one_of_two_entities_with_one_name(viewed, ask, open_page):
    """A door and a place of the hospital are called pharmacy."""
    endpoint, url = viewed("hospital")
    simulator, page = ask(endpoint), open_page(url)

    for text in ("wall_e", "pharmacy"):
        page.keyboard.press("/")
        page.keyboard.type(text)
        page.keyboard.press("Enter")
        page.keyboard.press("m")
    until(page, "hmrsim.model.robots.get('wall_e').goal !== null")
    (robot,) = [each for each in simulator.scene()["robots"] if each["name"] == "wall_e"]
    (goal,) = [each for each in robot["goals"] if each["action"] == "navigate_to_pose"]
    position = goal["goal"]["pose"]["pose"]["position"]

    assert (6.0, 18.0) == (position["x"], position["y"])


def test_the_search_offers_both_entities_of_one_name_by_their_kind(viewed, open_page):
    """The chosen door, not the place of its name, is the destination."""
    _, url = viewed("hospital")
    page = open_page(f"{url}?follow=wall_e")
    page.keyboard.press("m")
    page.keyboard.press("/")
    page.keyboard.type("pharmacy")

    options = page.get_by_role("option")
    expect(options.nth(0)).to_contain_text("place · send wall_e here")
    expect(options.nth(1)).to_contain_text("door · send wall_e here")
    options.nth(1).click()

    until(page, "hmrsim.model.robots.get('wall_e').goal?.goal")
    goal = page.evaluate("hmrsim.model.robots.get('wall_e').goal.goal.pose.pose.position")
    assert page.evaluate("hmrsim.model.doors.get('pharmacy').at.map(([x]) => x)")[0] < goal["x"]
    assert 12 < goal["y"] < 15
    expect(page.locator(".toasts")).to_contain_text("wall_e is driving to door pharmacy.")


def test_a_goal_at_a_named_place_is_named_in_the_list_also_in_its_error(viewed, ask, open_page):
    endpoint, url = viewed("hospital", "--real-time-factor", "0")
    simulator, page = ask(endpoint), open_page(f"{url}?panel=goals")
    x, y = page.evaluate("hmrsim.model.world.point('pharmacy')")
    pose = {"pose": {"position": {"x": x + 0.004, "y": y - 0.004}}}

    simulator.do("wall_e", "navigate_to_pose", pose=pose)
    simulator.do("m_o", "navigate_to_pose", pose={"pose": {"position": {"x": x, "y": y}}})

    rows = page.get_by_role("table", name="Goals").get_by_role("row")
    expect(rows.filter(has_text="wall_e")).to_contain_text("go to pharmacy")
    expect(rows.filter(has_text="m_o")).to_contain_text("go to pharmacy")
    expect(rows.filter(has_text="no route from charger_4 to pharmacy")).to_have_count(1)
