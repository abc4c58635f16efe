"""Playback of a recording on the page."""

from __future__ import annotations

import pytest

from benchmarks._browser import until

_AT = "() => hmrsim.model.robots.get('wall_e').poseAt(hmrsim.clock.now()).slice(0, 2)"
_GOAL = {"pose": {"pose": {"position": {"x": 512, "y": 215}}}}


@pytest.fixture
def recording(start, ask, tmp_path):
    """Return a recording of the first half of scenario 1."""
    file = tmp_path / "scenario1.mcap"
    run = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0", "--record", file)
    simulator = ask(run.ready["endpoints"][0])
    assert simulator.do("wall_e", "navigate_to_pose", **_GOAL) == 4
    simulator.call("inject_fault", type="lane_closed", name="party", lane=["lobby", "crossing"])
    assert simulator.do("wall_e", "pickup", target_name="medicine") == 4
    run.end()
    return file


def test_a_recording_plays_pauses_seeks_and_jumps_to_marks(recording, start, open_page):
    page = open_page(start("view", recording, "--port", 0).ready["url"])
    page.evaluate("hmrsim.playback.pause()")

    page.evaluate("hmrsim.playback.seek(hmrsim.playback.begin)")
    assert [515, 80] == pytest.approx(page.evaluate(_AT), abs=0.01)

    page.evaluate("hmrsim.playback.seek(hmrsim.playback.end)")
    assert [512, 215] == pytest.approx(page.evaluate(_AT), abs=0.01)
    assert page.evaluate("hmrsim.model.robots.get('wall_e').holds") == ["medicine"]
    assert page.evaluate("[...hmrsim.model.goals.values()].map((goal) => goal.status)") == [4, 4]

    page.evaluate("hmrsim.playback.seek(hmrsim.playback.begin)")
    assert page.evaluate("hmrsim.model.robots.get('wall_e').holds") == []
    assert page.evaluate("hmrsim.model.goals.size") == 0
    page.evaluate("hmrsim.playback.jump(1)")
    assert page.evaluate("hmrsim.playback.marks.map((mark) => [mark.kind, mark.t])") == [
        ["fault", page.evaluate("hmrsim.playback.time")]
    ]
    assert page.evaluate("hmrsim.model.closedLanes.has('lobby|crossing')")

    page.evaluate("hmrsim.playback.speed = 8")
    page.evaluate("hmrsim.playback.play()")
    until(page, "hmrsim.playback.time >= hmrsim.playback.end")
    assert [512, 215] == pytest.approx(page.evaluate(_AT), abs=0.01)


def test_a_recording_takes_no_commands_and_is_named(recording, start, open_page):
    page = open_page(start("view", recording, "--port", 0).ready["url"])

    assert page.evaluate("hmrsim.live === undefined || hmrsim.live === null")
    assert "scenario 1" in page.evaluate("document.documentElement.textContent + document.title")
