"""The coverage of trees on the command line."""

from __future__ import annotations

import json

import pytest
from py_trees.behaviours import Failure, Success
from py_trees.composites import Selector

from bt_controller.cli import main
from bt_controller.coverage import TreeCoverage


@pytest.fixture
def seen(tmp_path):
    """Return a file: the first child fails, the second makes up for it, and the third is not ticked."""
    coverage = TreeCoverage()
    children = [Failure("A"), Success("B"), Success("C")]
    coverage.watch("trees:errand", Selector("Root", memory=True, children=children)).tick()
    path = tmp_path / "seen.json"
    path.write_text(json.dumps(coverage.to_json()), encoding="utf-8")
    return str(path)


def test_a_table_says_what_never_happened(seen, capsys):
    assert 0 == main(["coverage", seen])

    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert "trees:errand: 4 of 5 outcomes (80%) in 1 run of the tree" == " ".join(lines[0])
    assert ["node", "ticks", "succeeded", "failed", "canceled", "recovered", "goals"] == lines[1]
    assert ["A", "1", "-", "1", "-", "1"] == lines[3]
    assert ["C", "never", "never", "-", "-", "-"] == lines[5]


def test_files_are_counted_together(seen, capsys):
    main(["coverage", seen, seen])

    assert "in 2 runs of the tree" in capsys.readouterr().out


def test_only_what_is_missing_is_shown_if_wanted(seen, capsys):
    main(["coverage", seen, "--missing"])

    assert ["C"] == [line.split()[0] for line in capsys.readouterr().out.splitlines()[2:]]


def test_programs_get_the_same_as_json(seen, capsys):
    main(["coverage", seen, "--json"])

    (tree,) = json.loads(capsys.readouterr().out)["trees"]
    assert {"seen": 4, "possible": 5, "share": 0.8} == tree["covered"]
    assert ["ticked", "succeeded"] == tree["nodes"][3]["never"]


def test_a_tracefile_has_its_outline_beside_it(seen, tmp_path):
    main(["coverage", seen, "-o", str(tmp_path / "seen.info")])

    outline = tmp_path / "seen.outline.txt"
    assert f"SF:{outline}\n" in (tmp_path / "seen.info").read_text(encoding="utf-8")
    assert outline.read_text(encoding="utf-8").startswith("trees:errand\nSelector Root\n    Failure A\n")


def test_several_files_become_one(seen, tmp_path):
    main(["coverage", seen, seen, "-o", str(tmp_path / "both.json")])

    assert {"seen.json", "both.json"} == {path.name for path in tmp_path.iterdir()}
    assert 2 == TreeCoverage.from_json((tmp_path / "both.json").read_text(encoding="utf-8")).runs("trees:errand")


def test_a_file_that_is_no_coverage_is_an_error(tmp_path, capsys):
    (tmp_path / "other.json").write_text("{}", encoding="utf-8")

    assert 2 == main(["coverage", str(tmp_path / "other.json")])
    assert "other.json: no coverage of trees: format: Field required" in capsys.readouterr().err


def test_an_ending_that_says_no_format_is_an_error(seen, capsys):
    assert 2 == main(["coverage", seen, "-o", "seen.html"])

    assert "--output seen.html has no known format; expected a name that ends with" in capsys.readouterr().err
