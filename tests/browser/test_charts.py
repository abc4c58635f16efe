"""Plots of numbers in topics, live and in a recording."""

from __future__ import annotations

import re

from playwright.sync_api import expect


def _plot(page, topic, number):
    topics = page.get_by_label("Topic", exact=True)
    expect(topics.locator("option", has_text=topic)).to_have_count(1)
    topics.select_option(topic)
    page.get_by_label("Number", exact=True).select_option(number)
    page.get_by_role("button", name="Plot", exact=True).click()
    return page.get_by_role("region", name=f"{topic} · {number}")


def test_any_number_of_a_topic_is_plotted_and_the_plot_removed(viewed, ask, open_page):
    endpoint, url = viewed("scenario1", "--real-time-factor", "20")
    simulator, page = ask(endpoint), open_page(f"{url}?panel=charts")
    plot = _plot(page, "odom", "pose.pose.position.x")
    expect(plot.get_by_role("img")).to_have_attribute("aria-label", "wall_e 515")

    assert 4 == simulator.do("wall_e", "navigate_to_pose", pose={"pose": {"position": {"x": 400, "y": 300}}})
    expect(plot.get_by_role("img")).to_have_attribute("aria-label", "wall_e 400")
    expect(_plot(page, "_world/time/state", "real_time_factor").get_by_role("img")).to_have_attribute(
        "aria-label", "20"
    )

    plot.get_by_role("button", name="Remove").click()
    expect(plot).to_have_count(0)


def test_a_number_of_a_recorded_topic_is_plotted_up_to_the_time_that_is_shown(start, ask, open_page, tmp_path):
    file = tmp_path / "hospital.mcap"
    run = start("run", "hospital", "--listen", "tcp/127.0.0.1:0", "--real-time-factor", "0", "--record", file)
    simulator = ask(run.ready["endpoints"][0])
    assert 4 == simulator.do("eve", "navigate_to_pose", pose={"pose": {"position": {"x": 25, "y": 19}}})
    run.end()
    page = open_page(f"{start('view', file, '--port', 0).ready['url']}?panel=charts&follow=eve")
    plot = _plot(page, "battery_state", "percentage").get_by_role("img")

    page.evaluate("hmrsim.playback.seek(hmrsim.playback.end)")
    expect(plot).to_have_attribute("aria-label", re.compile(r"eve 0\.98"))
    page.evaluate("(hmrsim.playback.pause(), hmrsim.playback.seek(hmrsim.playback.begin + 2))")
    expect(plot).to_have_attribute("aria-label", re.compile(r"eve 0\.99"))
