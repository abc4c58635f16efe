"""The names of robots, items and places on the map, live and in a recording."""

from __future__ import annotations

import json

from benchmarks._browser import until

_CROWDED = ["wall_e", "eve", "nan_e", "auto", "vaq_m", "d_fib"]
_WATCH = """([frames]) => new Promise((then) => {
  const overlaps = new Set();
  let fewest = Infinity;
  const meet = ([a, b, c, d], [x, y, width, height]) => a < x + width && x < a + c && b < y + height && y < b + d;
  const look = () => {
    const { labels } = hmrsim.map;
    labels.forEach((one, i) => labels.slice(0, i).forEach((other) => {
      if (meet(one.box, other.box)) overlaps.add(`${one.name} ${other.name}`);
    }));
    fewest = Math.min(fewest, labels.filter(({ name }) => hmrsim.model.robots.has(name)).length);
    frames -= 1;
    if (frames) requestAnimationFrame(look);
    else then([[...overlaps], fewest]);
  };
  requestAnimationFrame(look);
})"""
"""Return the names that overlapped within some frames, and the least number of robots with a name."""
WARD = {"pose": {"pose": {"position": {"x": 25, "y": 19}}}}


def test_names_do_not_overlap_while_robots_meet(viewed, ask, open_page):
    endpoint, url = viewed("hospital", "--real-time-factor", "5")
    simulator, page = ask(endpoint), open_page(f"{url}?panel=none", viewport={"width": 390, "height": 844})
    for robot in _CROWDED:
        simulator.send(robot, "navigate_to_pose", **WARD)
    until(page, "hmrsim.model.robots.get('d_fib').goal === null && hmrsim.model.goals.size >= 6")

    overlaps, named = page.evaluate(_WATCH, [60])

    assert [] == overlaps
    assert 8 == named


def test_names_do_not_overlap_in_a_recording(start, ask, open_page, tmp_path):
    file = tmp_path / "hospital.mcap"
    run = start("run", "hospital", "--listen", "tcp/127.0.0.1:0", "--real-time-factor", "0", "--record", file)
    simulator = ask(run.ready["endpoints"][0])
    goals = [(robot, simulator.send(robot, "navigate_to_pose", **WARD)) for robot in _CROWDED]
    for robot, goal in goals[:3]:
        simulator.result(robot, "navigate_to_pose", goal)
    run.end()
    page = open_page(start("view", file, "--port", 0).ready["url"], viewport={"width": 820, "height": 900})
    page.evaluate("hmrsim.playback.speed = 20")

    overlaps, named = page.evaluate(_WATCH, [60])

    assert [] == overlaps
    assert 8 == named


def test_a_line_leads_from_a_robot_to_a_name_that_has_no_room_beside_it(viewed, open_page):
    _, url = viewed("hospital", "--robot", "pinned@23,4.5")
    page = open_page(f"{url}?panel=none", viewport={"width": 390, "height": 844})
    until(page, "hmrsim.map.labels.some(({ name }) => name === 'pinned')")

    away = page.evaluate("""() => hmrsim.map.labels.filter(({ name, box }) => {
      const robot = hmrsim.model.robots.get(name);
      if (!robot) return false;
      const [x, y] = hmrsim.map.toScreen(...robot.poseAt(hmrsim.clock.now()));
      const [dx, dy] = [Math.max(box[0] - x, x - box[0] - box[2]), Math.max(box[1] - y, y - box[1] - box[3])];
      return Math.max(dx, dy) > 20;
    }).map(({ line }) => line)""")

    assert away
    assert all(away)


def test_a_few_waypoints_have_names_however_large_the_world_is(viewed, open_page, tmp_path):
    names = [f"packing_station_{number}" for number in range(12)]
    world = tmp_path / "long.yaml"
    world.write_text(
        json.dumps({"waypoints": {name: [40 * (i % 4), 40 * (i // 4)] for i, name in enumerate(names)}}),
        encoding="utf-8",
    )
    _, url = viewed(world)

    page = open_page(url)
    until(page, "hmrsim.map.labels.length")

    assert set(names) == {label["name"] for label in page.evaluate("hmrsim.map.labels")}
