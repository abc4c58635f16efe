"""Writes the wheel's bill of materials in CycloneDX: its content and its dependencies.

Run as ``python -m tools.sbom [--check]``; sbom.cdx.json is generated from the versions of requirements.lock, from what
the packages say that they need, and from the library that the page contains. It is that of Linux with the least Python
that is supported, whatever runs this, and has no time and no random number: a wheel that is built twice is the same.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import distribution
from pathlib import Path
from typing import Any, Final

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from hmrsim import __version__

_FILE: Final = Path("sbom.cdx.json")
_NAME: Final = "hmrsim"
_LOCK: Final = Path("requirements.lock")
_PLATFORM: Final = {
    "python_version": "3.11",
    "python_full_version": "3.11.0",
    "sys_platform": "linux",
    "platform_system": "Linux",
    "os_name": "posix",
    "implementation_name": "cpython",
    "platform_python_implementation": "CPython",
}
_UPLOT: Final = Path("hmrsim_zenoh/view/page/vendor/uplot/uPlot.esm.js")


def main(argv: Sequence[str] | None = None) -> int:
    """Write the file, or report that it is out of date."""
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
    """Return the bill: hmrsim, its required packages, its vendored parts, and the dependencies among them."""
    needs: dict[str, list[str]] = {}
    todo = [_NAME]
    while todo:
        name = todo.pop()
        if name not in needs:
            needs[name] = sorted(set(_needed(name)))
            todo += needs[name]
    versions = {**_locked(), _NAME: __version__}
    packages = {name: _component(f"pkg:pypi/{name}", versions[name]) for name in sorted(needs)}
    copied = {**_component("pkg:npm/uplot", _version_of_uplot()), "licenses": [{"license": {"id": "MIT"}}]}
    depends = {packages[name]["purl"]: [packages[each]["purl"] for each in needs[name]] for name in packages}
    main_component = packages.pop(_NAME)
    depends[main_component["purl"]].append(copied["purl"])
    depends[copied["purl"]] = []
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": {**main_component, "type": "application"}},
        "components": [*packages.values(), copied],
        "dependencies": [{"ref": one, "dependsOn": others} for one, others in depends.items()],
    }


def _needed(package: str) -> Iterator[str]:
    for text in distribution(package).requires or ():
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": "", **_PLATFORM}):
            yield canonicalize_name(requirement.name)


def _locked() -> dict[str, str]:
    """Return the versions of requirements.lock."""
    lines = re.findall(r"^([a-z].*) \\$", _LOCK.read_text(encoding="utf-8"), re.MULTILINE)
    found = [Requirement(line) for line in lines]
    return {
        canonicalize_name(one.name): str(one.specifier).removeprefix("==")
        for one in found
        if one.marker is None or one.marker.evaluate(_PLATFORM)
    }


def _version_of_uplot() -> str:
    """Return the version in the header of the wheel's copy."""
    found = re.search(r"uPlot \(v([\d.]+)\)", _UPLOT.read_text(encoding="utf-8"))
    if found is None:
        raise ValueError(f"{_UPLOT}: no version of uPlot, such as (v1.6.32), in its first lines")
    return found[1]


def _component(package: str, version: str) -> dict[str, Any]:
    purl = f"{package}@{version}"
    return {"type": "library", "bom-ref": purl, "name": package.rsplit("/", 1)[1], "version": version, "purl": purl}


if __name__ == "__main__":
    sys.exit(main())
