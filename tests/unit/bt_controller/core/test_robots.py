"""Selecting robots by name, type and role."""

from __future__ import annotations

import pytest

from bt_controller.core.robots import Directory, NotServed, check_selector, completions, selected

WARD = Directory.from_info(
    {
        "robots": [
            {"name": "wall_e", "type": "nurse", "components": ["claw"], "actions": ["pickup", "wait"]},
            {"name": "m_o", "type": "cleaner", "components": ["battery"], "actions": ["wait"]},
            {"name": "eve", "type": "courier", "components": ["claw"], "actions": ["pickup", "wait"]},
        ]
    }
)


@pytest.mark.parametrize(
    ("selectors", "robots"),
    [
        (["all"], ["eve", "m_o", "wall_e"]),
        (["type:nurse"], ["wall_e"]),
        (["action:pickup"], ["eve", "wall_e"]),
        (["component:battery"], ["m_o"]),
        (["type:nurse", "component:claw", "type:cleaner"], ["eve", "m_o", "wall_e"]),
    ],
)
def test_robots_are_selected_by_what_they_are(selectors, robots):
    assert robots == selected(WARD, selectors)


@pytest.mark.parametrize(
    ("selector", "error"),
    [
        ("type:nurs", "no robot has type 'nurs'; did you mean type:nurse?"),
        ("action:dock_robot", "no robot has action 'dock_robot'; there are pickup, wait"),
        ("component:lidar", "no robot has component 'lidar'; there are battery, claw"),
    ],
)
def test_a_selector_that_matches_no_robot_says_what_there_is(selector, error):
    with pytest.raises(NotServed, match=f"^{error}$".replace("?", r"\?")):
        selected(WARD, ["all", selector])


def test_a_world_without_robots_has_none_to_select():
    with pytest.raises(NotServed, match="there are no robots"):
        selected(Directory.from_info({}), ["all"])


@pytest.mark.parametrize("selector", ["nurse", "type:", "kind:nurse", "all:", ""])
def test_a_malformed_selector_is_refused(selector):
    with pytest.raises(ValueError, match="selects no robots; expected all, type:NAME, action:NAME, component:NAME"):
        check_selector(selector)


def test_shell_completion_offers_what_there_is():
    assert [
        "all",
        "action:pickup",
        "action:wait",
        "component:battery",
        "component:claw",
        "type:cleaner",
        "type:courier",
        "type:nurse",
    ] == completions(WARD)
