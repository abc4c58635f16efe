"""The files in schemas/ are those that the models make."""

from __future__ import annotations

import shutil

from hmrsim.actions import registry
from hmrsim_zenoh.schemas import main
from tests.paths import ROOT

SCHEMAS = ROOT / "schemas"


def test_the_committed_schemas_are_in_step():
    """After a change of a model, run make schemas."""
    assert 0 == main(["--check", str(SCHEMAS)])


def test_a_schema_that_is_out_of_date_is_named(tmp_path, capsys):
    """The check writes nothing, and says which file and what to do."""
    shutil.copytree(SCHEMAS, tmp_path, dirs_exist_ok=True)
    (tmp_path / "world.schema.json").write_text("{}")

    assert 1 == main(["--check", str(tmp_path)])
    assert f"{tmp_path}/world.schema.json: out of date; run make schemas" in capsys.readouterr().err
    assert "{}" == (tmp_path / "world.schema.json").read_text()


def test_every_action_has_a_schema():
    assert sorted(registry()) == sorted(path.name.split(".")[0] for path in (SCHEMAS / "actions").iterdir())
