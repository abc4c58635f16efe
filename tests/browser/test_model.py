"""The page's model, run in Node.js if it is installed, else in the browser."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from hmrsim.drawing import PALETTE, type_looks
from hmrsim.events import Part
from hmrsim.world.model import World
from hmrsim.world_checks.resolved import shown

_HERE = Path(__file__).parent
_PAGE = _HERE.parents[1] / "hmrsim_zenoh" / "view" / "page"

WORLD = {
    "name": "small",
    "waypoints": {"a": [0, 0], "b": {"at": [10, 0], "capacity": 3}, "c": [10, 10], "up": [110, 10]},
    "lanes": [["a", "b"], {"from": "b", "to": "c", "one_way": True, "speed_limit": 0.5, "capacity": 2}, ["c", "b"]],
    "traffic": {"policy": "reserve", "lane_capacity": 4},
    "walls": [[[0, 5], [5, 5]], {"solid": [[20, 20], [21, 20], [21, 21]]}],
    "doors": {"gate": {"at": [[5, -1], [5, 1]], "opening_time": 1.5}},
    "lifts": {"lift": {"stops": ["c", "up"], "travel_time": 6}},
    "places": {"ward": {"at": [10, 10]}},
    "docks": {"charger": {"at": "a", "type": "charger"}},
    "items": {"medicine": {"at": "ward", "weight": 0.2}},
    "robot_types": {"nurse": {"base": {"speed": 2, "radius": 0.3}}},
    "robots": {"wall_e": {"type": "nurse", "at": "charger", "yaw": 1}, "eve": {"at": "b"}},
}


@pytest.fixture
def evaluate(request):
    """Return the function that runs a script's checks."""

    def in_node(script, view, *more):
        argument = json.dumps([str(_PAGE), view, *more])
        program = f"console.log(JSON.stringify(await ({script.rstrip().rstrip(';')})({argument})))"
        command = ["node", "--experimental-default-type=module", "--input-type=module", "--eval", program]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.stdout, done.stderr
        return json.loads(done.stdout.splitlines()[-1])

    def in_browser(script, view, *more):
        _, url = request.getfixturevalue("viewed")("scenario1")
        return request.getfixturevalue("open_page")(url).evaluate(script, ["", view, *more])

    return in_node if shutil.which("node") else in_browser


@pytest.fixture
def view():
    """Return the `_world/view` of a small world."""
    return json.loads(json.dumps(shown(World.model_validate(WORLD))))


@pytest.mark.parametrize(("checks", "least"), [("model_checks.js", 40), ("source_checks.js", 9)])
def test_the_model_follows_worlds_scenes_events_and_recordings(evaluate, view, checks, least):
    checked = evaluate(_checks(checks), view)

    assert {} == checked["wrong"]
    assert checked["claims"] >= least


def test_the_page_handles_events_by_declarations_of_their_kinds(evaluate, view):
    """The same kinds with other names have the same effect."""
    renamed = view | {"events": {f"plugin_{kind}": entry for kind, entry in view["events"].items()}}

    assert {} == evaluate(_checks("model_checks.js"), renamed, "plugin_")["wrong"]


def test_the_page_knows_each_part_that_events_change(evaluate, view):
    known = evaluate("async ([base]) => [...(await import(`${base}/model/changes.js`)).CHANGES.keys()]", view)

    assert sorted(Part) == sorted(known)


_LOOKS = """async ([base, view, palette]) => {
  globalThis.Path2D = class { constructor(data) { this.data = data; } };
  const { lookOf } = await import(`${base}/map/shapes.js`);
  const { World } = await import(`${base}/model/world.js`);
  const world = new World(view.world);
  return [...world.types.keys()].map((name) => [name, lookOf(world.typeIndex(name), palette)])
    .map(([name, { color, shape }]) => [name, [color, shape.data]]);
}"""


def test_robots_have_the_shapes_and_colors_of_other_drawings(evaluate, view):
    looks = dict(evaluate(_LOOKS, view, PALETTE))

    drawn = {name: [*look] for name, look in type_looks(World.model_validate(WORLD)).items()}
    assert {name: looks[name] for name in drawn} == drawn
    assert 2 == len(drawn)


def _checks(name):
    script = (_HERE / name).read_text("utf-8")
    return script[script.index("async (") :]
