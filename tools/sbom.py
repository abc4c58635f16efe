"""Writes the bill of materials that the wheel contains: CycloneDX, what is in it and what is installed with it.

Run as ``python -m tools.sbom [--check]``; sbom.cdx.json is generated from the metadata of what is installed, which is
what requirements.lock says, and from the libraries that the page contains.
It has no time and no random number, so that a wheel that is built twice is the same.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import Distribution, distribution
from pathlib import Path
from typing import Any, Final

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from hmrsim import __version__

_FILE: Final = Path("sbom.cdx.json")
_NAME: Final = "hmrsim"
_UPLOT: Final = Path("hmrsim_zenoh/view/page/vendor/uplot/uPlot.esm.js")


def main(argv: Sequence[str] | None = None) -> int:
    """Write the file, or say that it is out of date."""
    parser = argparse.ArgumentParser(prog="python -m tools.sbom", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if something is wrong")
    arguments = parser.parse_args(argv)
    new = json.dumps(_bill(), indent=1) + "\n"
    if arguments.check and (not _FILE.exists() or _FILE.read_text(encoding="utf-8") != new):
        sys.stderr.write(f"{_FILE}: out of date; run make schemas\n")
        return 1
    if not arguments.check:
        _FILE.write_text(new, encoding="utf-8")
    return 0


def _bill() -> dict[str, Any]:
    """Return the bill: hmrsim, the packages that it needs without extras, and who needs whom."""
    found: dict[str, Distribution] = {}
    needs: dict[str, list[str]] = {}
    todo = [_NAME]
    while todo:
        name = todo.pop()
        if name in needs:
            continue
        found[name] = distribution(name)
        needs[name] = sorted(set(_needed(found[name])))
        todo += needs[name]
    charts = _uplot()
    packages = [{"type": "library", "bom-ref": _reference(name, found), **_of(name, found)} for name in sorted(found)]
    depends = {_reference(name, found): [_reference(each, found) for each in needs[name]] for name in sorted(found)}
    depends[_reference(_NAME, found)].append(charts["bom-ref"])
    depends[charts["bom-ref"]] = []
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": {"type": "application", "bom-ref": _reference(_NAME, found), **_of(_NAME, found)}},
        "components": [*(package for package in packages if package["name"] != _NAME), charts],
        "dependencies": [{"ref": one, "dependsOn": others} for one, others in depends.items()],
    }


def _uplot() -> dict[str, Any]:
    """Return the library whose copy is in the wheel; its version stands in the file itself."""
    found = re.search(r"uPlot \(v([\d.]+)\)", _UPLOT.read_text(encoding="utf-8"))
    if found is None:
        raise ValueError(f"{_UPLOT}: no version of uPlot, such as (v1.6.32), in its first lines")
    reference = f"pkg:npm/uplot@{found[1]}"
    return {
        "type": "library",
        "bom-ref": reference,
        "name": "uplot",
        "version": found[1],
        "licenses": [{"license": {"id": "MIT"}}],
        "purl": reference,
    }


def _needed(package: Distribution) -> Iterator[str]:
    for text in package.requires or ():
        requirement = Requirement(text)
        # As on Linux with the least Python that is supported, whatever this one is.
        if requirement.marker is None or requirement.marker.evaluate({"extra": "", **_PLATFORM}):
            yield canonicalize_name(requirement.name)


_PLATFORM: Final = {
    "python_version": "3.11",
    "python_full_version": "3.11.0",
    "sys_platform": "linux",
    "platform_system": "Linux",
    "os_name": "posix",
    "implementation_name": "cpython",
    "platform_python_implementation": "CPython",
}


def _version(name: str, found: dict[str, Distribution]) -> str:
    return __version__ if name == _NAME else found[name].version


def _reference(name: str, found: dict[str, Distribution]) -> str:
    return f"pkg:pypi/{name}@{_version(name, found)}"


def _of(name: str, found: dict[str, Distribution]) -> dict[str, str]:
    return {"name": name, "version": _version(name, found), "purl": _reference(name, found)}


if __name__ == "__main__":
    sys.exit(main())
