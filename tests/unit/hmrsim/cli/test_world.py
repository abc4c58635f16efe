"""``hmrsim world``."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main
from hmrsim.world.files import shipped_maps
from hmrsim.world_checks import load_world


def test_shipped_worlds_are_listed_with_what_they_are(capsys):
    """A line each."""
    assert 0 == main(["world", "list"])

    lines = capsys.readouterr().out.splitlines()
    assert list(shipped_maps()) == [line.split()[0] for line in lines]
    assert all(len(line.split()) > 1 for line in lines)


def test_a_new_world_is_right_and_has_its_schema_beside_it(tmp_path):
    """It loads without a warning, and is called as its file."""
    file = tmp_path / "ward.yaml"

    assert 0 == main(["world", "new", str(file)])

    loaded = load_world(file)
    assert ("ward", ()) == (loaded.world.name, tuple(loaded.warnings))
    assert file.read_text().startswith("# yaml-language-server: $schema=world.schema.json\n")
    assert json.loads((tmp_path / "world.schema.json").read_text())["properties"]["waypoints"]


@pytest.mark.parametrize(
    ("name", "message"), [("ward.json", "expected a name that ends in .yaml"), ("there.yaml", "exists already")]
)
def test_a_file_that_is_not_to_be_written_is_left_alone(tmp_path, capsys, name, message):
    """Nothing is lost."""
    (tmp_path / "there.yaml").write_text("mine")

    assert 2 == main(["world", "new", str(tmp_path / name)])

    assert message in capsys.readouterr().err
    assert "mine" == (tmp_path / "there.yaml").read_text()


def test_the_schema_is_printed(capsys):
    """As JSON."""
    main(["world", "schema"])

    assert json.loads(capsys.readouterr().out)["properties"]["waypoints"]
