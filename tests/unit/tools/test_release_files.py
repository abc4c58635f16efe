"""Files of a release tell the same version and licence."""

from __future__ import annotations

import json
import tomllib

import yaml

from hmrsim import __version__
from tests.paths import ROOT


def test_the_version_is_the_same_everywhere():
    """In the package, its metadata, the citation, the bill of materials and the header of the site."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    bill = json.loads((ROOT / "sbom.cdx.json").read_text())["metadata"]["component"]

    site = tomllib.loads((ROOT / "zensical.toml").read_text())["project"]["site_name"]

    assert {__version__} == {project["version"], citation["version"], bill["version"], site.removeprefix("hmrsim ")}
    assert project["license"] == citation["license"] == "Apache-2.0"


def test_the_bill_and_the_notice_list_what_the_page_contains():
    vendored = ROOT / "hmrsim_zenoh" / "view" / "page" / "vendor"
    bill = json.loads((ROOT / "sbom.cdx.json").read_text())
    copied = {one["name"]: one["version"] for one in bill["components"] if one["purl"].startswith("pkg:npm/")}

    assert {folder.name.lower() for folder in vendored.iterdir() if folder.is_dir()} == copied.keys()
    assert f"uPlot {copied['uplot']}" in (ROOT / "NOTICE").read_text()
