"""Kinds of data blocks, and checks that hmrsim accepts them."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any, Final

import yaml
import zenoh

from hmrsim.experiments.reading import read_plan
from hmrsim.fault_search.reading import read_check
from hmrsim.fault_search.schedule import read_injections
from hmrsim.properties import check_properties, read_properties
from hmrsim.settings.run import read_file
from hmrsim.testing import simulation
from hmrsim.world.overlays.overlay import overlays_of
from hmrsim.world_checks import load_world
from hmrsim_zenoh.settings import SERVED
from tests.paths import ROOT

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

_ACTION: Final = re.compile(r"^[\w.-]+/[\w./-]+@\S+$")


def is_world(text: str, folder: Path, base: str) -> None:
    """Load a world, or a part of one with the rest from the file that the comment names."""
    load_world(_written(f"include: [{base}]\n{text}" if base else text, folder))


def is_overlay(text: str, folder: Path, base: str) -> None:
    """Apply changes to a world."""
    world = str(folder / base) if (folder / base).exists() else base
    load_world(world, overlays=overlays_of([str(_written(text, folder))], []))


def is_settings(text: str, folder: Path, _: str) -> None:
    assert read_file(_written(text, folder), SERVED)


def is_experiment(text: str, folder: Path, rest: str) -> None:
    """Read an experiment with its world and controllers; the rest of a part is in another file."""
    more = (folder / rest).read_text(encoding="utf-8") if rest else ""
    assert read_plan(_written(text + more, folder)).scenarios


def is_check(text: str, folder: Path, _: str) -> None:
    """Read a check, with the files that it names."""
    assert read_check(_written(text, folder))


def is_properties(text: str, folder: Path, world: str) -> None:
    """Read properties, or some lines of them, and check their names in a world."""
    whole = text if text.lstrip("# ").startswith(("properties:", "yaml-")) else f"properties:\n{text}"
    found = check_properties(read_properties(_written(whole, folder)), load_world(world or "hospital").world)
    assert not [finding for finding in found if finding.severity == "error"], found


def is_part(text: str, _: Path, name: str) -> None:
    """Find these lines, unchanged, in a file of the repository."""
    file = (ROOT / name).read_text(encoding="utf-8")
    assert _unindented(text) in _unindented(file), f"these lines are not in {name}"


def is_schedule(text: str, _: Path, __: str) -> None:
    """Read the disturbances of a failure's file."""
    _, findings = read_injections(yaml.safe_load(text))
    assert not findings


def is_payload(text: str, _: Path, where: str) -> None:
    """Find exactly these fields, or these entries of a field, in the value of a world's key."""
    world, key, *field = where.split()
    with simulation(world) as run:
        run.client.sleep(120)
        there = json.loads(run.client.get(key))
    shown = json.loads(text)
    if field:
        assert shown.items() <= there[field[0]].items(), f"at {key} there is no {shown}"
    else:
        assert _alike(there, shown), f"at {key} there is {there}"


def is_lines(text: str, _: Path, __: str) -> None:
    for line in text.splitlines():
        json.loads(line)


def is_json5(text: str, folder: Path, _: str) -> None:
    """Read a configuration of Zenoh."""
    file = folder / "block.json5"
    file.write_text(text, encoding="utf-8")
    zenoh.Config.from_file(str(file))


def is_workflow(text: str, _: Path, __: str) -> None:
    """Check the required parts of a GitHub workflow, and the version of each action."""
    workflow = yaml.safe_load(text)
    assert {"name", True, "jobs"} <= workflow.keys()  # YAML 1.1 takes `on` for a truth value
    for job in workflow["jobs"].values():
        assert job["runs-on"]
        for step in job["steps"]:
            assert "run" in step or _ACTION.match(step["uses"]), step


def is_gitlab(text: str, _: Path, __: str) -> None:
    """Check the required parts of a GitLab pipeline: jobs with scripts."""
    for job in yaml.safe_load(text).values():
        assert all(isinstance(line, str) for line in job["script"]), job


KINDS: Final[dict[str, Callable[[str, Path, str], None]]] = {
    "check": is_check,
    "experiment": is_experiment,
    "gitlab": is_gitlab,
    "overlay": is_overlay,
    "json lines": is_lines,
    "part of": is_part,
    "payload": is_payload,
    "properties": is_properties,
    "schedule": is_schedule,
    "settings": is_settings,
    "workflow": is_workflow,
    "world": is_world,
    "zenoh": is_json5,
}
"""How a block of data is looked at, by the comment before it."""


def _alike(there: Any, shown: Any) -> bool:
    """Return whether both have the same fields at every depth, except null."""
    if isinstance(there, dict) and isinstance(shown, dict):
        return there.keys() == shown.keys() and all(_alike(there[name], shown[name]) for name in there)
    if isinstance(there, list) and isinstance(shown, list):
        return all(_alike(one, shown[0]) for one in there[:1])
    return True


def _unindented(text: str) -> str:
    return "\n".join(line.strip() for line in text.strip("\n").splitlines())


def _written(text: str, folder: Path) -> Path:
    file = folder / "block.yaml"
    file.write_text(text, encoding="utf-8")
    return file
