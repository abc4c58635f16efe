"""The problems that the check of a release reports."""

from __future__ import annotations

import zipfile

from tools.release import different, wrong_contents, wrong_tags


def test_a_file_that_is_built_otherwise_or_only_once_is_told():
    """By its name, whichever of the builds lacks it."""
    wrong = different({"a": "1", "b": "2", "c": "3"}, {"a": "1", "b": "9", "d": "4"})

    assert [f"{name}: built twice, it differs" for name in "bcd"] == wrong


def test_a_tag_has_to_be_the_version_and_the_changelog_to_have_a_section():
    """A commit without a tag is not released, so nothing is wrong with it."""
    changes = "# Changelog\n\n## [Unreleased]\n\n## [0.2.0] - 2026-01-01\n"

    assert [] == wrong_tags("0.3.0", [], changes)
    assert [] == wrong_tags("0.2.0", ["v0.2.0"], changes)
    assert ["tag v0.3.0: the version is 0.2.0; expected v0.2.0"] == wrong_tags("0.2.0", ["v0.3.0"], changes)
    assert ["CHANGELOG.md: no section [0.3.0]; what is new in it stands under [Unreleased]"] == wrong_tags(
        "0.3.0", ["v0.3.0"], changes
    )


def test_a_wheel_has_its_packages_and_its_bill_of_materials_and_nothing_else(tmp_path):
    """Tests in a wheel would be installed beside the user's own."""
    wheel = tmp_path / "hmrsim-1-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        for name in ("hmrsim/data/maps/cafe.yaml", "hmrsim-1.dist-info/METADATA", "tests/steps.py"):
            archive.writestr(name, "")
    wrong = [line.removeprefix(f"{wheel.name}: ") for line in wrong_contents(wheel, ["hmrsim"])]

    assert [
        "lacks hmrsim/data/schemas/world.schema.json",
        "lacks hmrsim/cli/map_new.yaml",
        "lacks its bill of materials",
        "has tests",
    ] == wrong
