"""The orders of a world's demand on the page: live, and played from a recording."""

from __future__ import annotations

import pytest
import yaml
from playwright.sync_api import expect

from benchmarks._browser import until

WORLD = {
    "name": "orders",
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [["a", "b"]],
    "robots": {"eve": {"at": "a", "type": "fetcher"}},
    "demand": [
        {"name": "food", "item": "soup", "at": "a", "to": "b", "arrives": 1, "count": 1, "within": 5000, "priority": 2},
        {"name": "tea", "at": "a", "to": "b", "arrives": 2, "count": 1},
    ],
}
SUCCEEDED = 4


@pytest.fixture
def world(tmp_path):
    """Return a world with two orders, of which one is due some day and one never."""
    file = tmp_path / "orders.yaml"
    file.write_text(yaml.safe_dump(WORLD))
    return file


def _deliver(simulator):
    assert SUCCEEDED == simulator.do("eve", "navigate_to_pose", pose={"pose": {"position": {"x": 10, "y": 0}}})
    assert SUCCEEDED == simulator.do("eve", "place", attached_object_name="soup_1")


def test_orders_are_shown_by_due_time(world, viewed, ask, open_page):
    """Orders from before the page was opened are shown as well."""
    endpoint, url = viewed(world, "--real-time-factor", "20")
    simulator = ask(endpoint)
    page = open_page(f"{url}?panel=none")
    until(page, "hmrsim.model.items.has('soup_1') && hmrsim.model.items.has('tea_1')")

    page.keyboard.press("o")

    rows = page.get_by_role("table", name="Orders").get_by_role("row")
    expect(rows).to_have_count(2)
    expect(rows.nth(0)).to_contain_text("soup_1")
    expect(rows.nth(0)).to_contain_text("a → b")
    expect(rows.nth(0)).to_contain_text("waiting")
    expect(rows.nth(0)).to_contain_text("priority 2")
    expect(rows.nth(0)).to_contain_text("due in 1 h")
    assert SUCCEEDED == simulator.do("eve", "pickup", target_name="soup_1")
    expect(rows.nth(0)).to_contain_text("by eve")
    rows.nth(0).get_by_role("button").click()
    until(page, "hmrsim.map.selected === 'eve'")
    _deliver(simulator)
    expect(rows).to_have_count(3)
    expect(rows.nth(0)).to_contain_text("tea_1")
    expect(rows.nth(2)).to_contain_text("delivered")
    expect(rows.nth(2)).to_contain_text("took")
    totals = page.locator(".totals")
    assert "open 1 placed 2 delivered 1 late 0 lost 0" == " ".join(totals.locator("dt, dd").all_text_contents())


def test_orders_of_a_recording_are_shown(world, start, ask, open_page, tmp_path):
    file = tmp_path / "orders.mcap"
    run = start("run", world, "--listen", "tcp/127.0.0.1:0", "--real-time-factor", "20", "--record", file)
    simulator = ask(run.ready["endpoints"][0])
    simulator.do("eve", "wait", time={"sec": 3})
    assert SUCCEEDED == simulator.do("eve", "pickup", target_name="soup_1")
    _deliver(simulator)
    run.end()
    page = open_page(f"{start('view', file, '--port', 0).ready['url']}?panel=orders")
    page.evaluate("hmrsim.playback.pause()")

    page.evaluate("hmrsim.playback.seek(hmrsim.playback.end)")
    until(page, "document.querySelector('.totals').textContent.includes('open1placed2delivered1')")
    page.evaluate("hmrsim.playback.seek(2.5)")
    until(page, "document.querySelector('.totals').textContent.includes('open2placed2delivered0')")


def test_a_world_without_demand_shows_one_line(viewed, open_page):
    _, url = viewed("scenario1")
    page = open_page(f"{url}?panel=orders")

    expect(page.locator(".side")).to_contain_text("No orders: this world has no demand.")
    expect(page.locator(".totals")).to_be_hidden()
