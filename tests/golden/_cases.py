"""The golden runs, and the texts that are pinned for each."""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from functools import partial
from pathlib import Path

import yaml

from tests.golden import _running as running

HERE = Path(__file__).parent
HASHES = HERE / "hashes.json"

_DIGITS = 9
"""As in traces: the last bit of a processor's arithmetic does not matter."""

_POLICIES = ("free", "reserve", "priority")
_ZOO = ("charger_queue", "corridor_swap", "crossing", "dead_end", "door", "lift", "token_swap")
_SHIPPED = ("hospital", "hospital_fleet", "scenario1", "scenario2", "warehouse", *(f"zoo/{name}" for name in _ZOO))
_SECONDS = 200.0
"""Simulated seconds of a shipped world: in the warehouse most robots have met by then."""
_TREES = {
    "recovery": ("examples/recovery.yaml", "examples/recovery.xml", ("wall_e",)),
    "scenario2": ("scenario2", "examples/scenario2.xml", ("wall_e",)),
    "battery_guard": ("examples/battery_guard.yaml", "examples.battery_guard:round_trip", ("wall_e",)),
    "fetch_and_deliver": ("scenario1", "examples.fetch_and_deliver:deliver", ("wall_e",)),
    "two_robots": ("examples/two_robots.yaml", "examples.two_robots:hand_over", ("wall_e", "eve")),
}
_PROGRAMS = {"state_machine": "scenario1", "lockstep_bare_keys": "hospital"}


def _simulated(world, folder):
    """Return the trace, the report and scenes of ``hmrsim simulate`` of a shipped world."""
    trace = running.traced_by_cli(folder, "simulate", world, "--duration", str(_SECONDS))
    run = running.Run(world)
    scenes = []
    for until in (10.0, 60.0, _SECONDS):
        run.finish(until)
        scenes.append(run.scene())
    return _pinned(folder, trace, scenes)


def _under(world, policy, folder):
    """Run a world of the zoo under a traffic policy, to the end of its scripts."""
    run = running.Run(world, {"traffic": {"policy": policy}})
    scenes = []
    for until in (5.0, 15.0, 3600.0):
        run.finish(until)
        scenes.append(run.scene())
    return _pinned(folder, run.trace(), scenes) | _heard(run)


def _told(story, folder):
    """Run a story: a world, and commands at given times."""
    run = running.Run(story["world"], story.get("changes"))
    scenes = []
    for at, order, *arguments in story["events"]:
        run.advance(at)
        if order == "look":
            scenes.append(run.scene())
        else:
            getattr(run, order)(*arguments)
    run.finish(story["until"])
    run.advance(story["until"])
    scenes.append(run.scene())
    return _pinned(folder, run.trace(), scenes) | _heard(run)


def _of_trace(make, folder, *arguments):
    """Return the texts of a run that has only its trace."""
    trace = make(*arguments)
    return _pinned(folder, trace, [running.last_scene(trace)])


def _demo(folder):
    """Run ``hmrsim demo`` in lockstep, with its three processes."""
    return _of_trace(running.traced_by_process, folder, folder, "demo", "--clock", "lockstep", "--json")


def _tree(world, tree, robots, folder, run=running.traced_tree):
    """Run an example tree in lockstep."""
    root = running.ROOT
    world = str(root / world) if "/" in world else world
    tree = str(root / tree) if tree.endswith(".xml") else tree
    return _of_trace(run, folder, world, tree, robots)


def _program(world, name, folder):
    """Run an example program in lockstep."""
    return _of_trace(running.traced_program, folder, world, running.ROOT / "examples" / f"{name}.py")


def _heard(run):
    """Return the messages that a client receives during a run."""
    lines = (json.dumps(_rounded(event)) + "\n" for event in run.events)
    return {"events.jsonl": "".join(lines)} | ({"answers.json": _text(run.answers)} if run.answers else {})


def _pinned(folder, trace, scenes):
    report = running.report_of(folder, trace)
    version = re.match(r'.*?"hmrsim":"([^"]*)"', trace)[1]
    return {
        "trace.jsonl": trace.replace(f'"hmrsim":"{version}"', '"hmrsim":"…"'),
        "report.json": _text(json.loads(report)).replace(json.dumps(version), '"…"'),
        "scenes.json": _text(scenes),
    }


def _text(plain):
    return json.dumps(_rounded(plain), indent=1) + "\n"


def _rounded(plain):
    if isinstance(plain, float):
        return round(plain, _DIGITS) + 0.0
    if isinstance(plain, dict):
        return {key: _rounded(value) for key, value in plain.items()}
    if isinstance(plain, (list, tuple)):
        return [_rounded(value) for value in plain]
    return plain


def _cases():
    yield "demo", _demo
    for name, asked in _TREES.items():
        yield f"tree/{name}", partial(_tree, *asked)
    for name, world in _PROGRAMS.items():
        yield f"program/{name}", partial(_program, world, name)
    for world in _SHIPPED:
        yield f"simulate/{world}", partial(_simulated, world)
    for name in _ZOO:
        for policy in _POLICIES:
            yield f"zoo/{name}/{policy}", partial(_under, f"zoo/{name}", policy)
    for path in sorted(HERE.glob("stories/*.yaml")):
        for name, story in yaml.safe_load(path.read_text()).items():
            if name != "common":
                yield f"{path.stem}/{name}", partial(_told, story)


CASES = dict(_cases())
WITHIN = {f"tree/{name}": partial(_tree, *asked, run=running.traced_tree_within) for name, asked in _TREES.items()}
"""The cases that are the same in one process, without a network."""


def made(name, cases=CASES):
    """Return the pinned texts of a case by file name."""
    with tempfile.TemporaryDirectory() as folder:
        return cases[name](Path(folder))


def digests(texts):
    """Return the number of lines and the hash of each text."""
    return {
        name: f"{text.count(chr(10))} {hashlib.sha256(text.encode()).hexdigest()[:16]}" for name, text in texts.items()
    }


def known():
    """Return the committed digests of all cases."""
    return json.loads(HASHES.read_text())
