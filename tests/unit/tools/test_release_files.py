"""Files of a release tell the same version and licence."""

from __future__ import annotations

import json
import tomllib

import yaml

from hmrsim import __version__
from tests.paths import ROOT


def test_the_version_is_the_same_everywhere():
    """In the package, its metadata, the citation and the bill of materials."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    bill = json.loads((ROOT / "sbom.cdx.json").read_text())["metadata"]["component"]

    assert {__version__} == {project["version"], citation["version"], bill["version"]}
    assert project["license"] == citation["license"] == "Apache-2.0"


def test_the_citation_has_what_its_format_asks_for():
    """Version 1.2.0 of the Citation File Format."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())

    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
    assert "1.2.0" == citation["cff-version"]
