"""The file that repeats a failure: world, schedule, properties, seed and controller."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hmrsim.fault_search.results.story import story_of
from hmrsim.world.writing import block

if TYPE_CHECKING:
    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.results.finding import Finding


def repro_text(check: Check, finding: Finding, path: Path) -> str:
    """Return the text of the file; *path* is where it will be."""
    story = story_of(finding)
    head = [f"# {line}".rstrip() for line in (f"hmrsim check --repro {path.name}", "", *story[: story.index("", 2)])]
    return "\n".join([*head, "", *_lines(check, finding, path)]) + "\n"


def _lines(check: Check, finding: Finding, path: Path) -> Iterator[str]:
    for key, value in _said(check, finding, path).items():
        yield from block(key, value)


def _said(check: Check, finding: Finding, path: Path) -> dict[str, Any]:
    """Return what the file says, in plain values."""
    controller = check.treatment.model_dump(mode="json", exclude_defaults=True)
    limits = {**check.file.limits.model_dump(mode="json", exclude_none=True), "simulated": check.limit}
    definition = finding.case.definition
    return {
        "repro": 1,
        "name": check.name,
        "failure": {"property": finding.failure.property, "reason": finding.failure.reason},
        "controller": controller,
        "folder": _from(check.folder, path.absolute().parent),
        **({} if check.file.world_seed is None else {"world_seed": check.file.world_seed}),
        "limits": limits,
        **({"trace": finding.trace_hash} if finding.trace_hash else {}),
        "schedule": [dict(thing.said) for thing in finding.schedule],
        "properties": check.properties.model_dump(mode="json", by_alias=True, exclude_defaults=True),
        "world": check.definition if definition is None else dict(definition),
    }


def _from(folder: Path, home: Path) -> str:
    """Return how a folder is called from another one."""
    return Path(os.path.relpath(folder, home)).as_posix()
