"""Coverage as LCOV's tracefile, read back by the format's description in geninfo's manual page."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import pytest
from py_trees.behaviours import Failure, Success
from py_trees.composites import Selector, Sequence

from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import lcov
from bt_controller.loading.trees import load
from bt_controller.running.runner import run_tree
from hmrsim.testing import simulation

EXAMPLE = Path(__file__).parents[4] / "examples" / "scenario2.xml"

RECORD = re.compile(r"(TN:\w*|SF:.+|BRDA:\d+,\d+,\d+,(\d+|-)|BRF:\d+|BRH:\d+|DA:\d+,\d+|LF:\d+|LH:\d+|end_of_record)")


def parsed(text):
    """Return the numbers of lines and branches by file; check that all is as geninfo's manual page says."""
    files = {}
    for section in text.split("end_of_record\n")[:-1]:
        lines = section.splitlines()
        assert all(RECORD.fullmatch(line) for line in lines)
        assert lines[0].startswith("TN:")
        found = defaultdict(list)
        for line in lines:
            key, _, value = line.partition(":")
            found[key].append(value)
        counts = dict(tuple(map(int, each.split(","))) for each in found["DA"])
        branches = {tuple(map(int, each.split(",")[:3])): each.split(",")[3] for each in found["BRDA"]}
        assert [len(counts)] == [*map(int, found["LF"])]
        assert [sum(count > 0 for count in counts.values())] == [*map(int, found["LH"])]
        assert [len(branches)] == [*map(int, found["BRF"])]
        assert [sum(taken not in {"-", "0"} for taken in branches.values())] == [*map(int, found["BRH"])]
        assert {line for line, _, _ in branches} <= counts.keys()
        files[found["SF"][0]] = counts, branches
    assert text.endswith("end_of_record\n")
    return files


@pytest.fixture(scope="module")
def example():
    """Return the lines and branches of the example's file."""
    coverage = TreeCoverage()
    with simulation("scenario2") as run:
        run_tree(run.client, load(str(EXAMPLE)), ["wall_e"], coverage=coverage)
    return parsed(lcov(coverage, Path("out.outline.txt"))[0])


def test_lines_are_those_of_the_file(example):
    counts, _ = example[str(EXAMPLE)]
    told = EXAMPLE.read_text(encoding="utf-8").splitlines()

    assert 2 == next(counts[number] for number, line in enumerate(told, 1) if "<NavigateToPose" in line)


def test_branches_are_what_can_happen(example):
    _, branches = example[str(EXAMPLE)]
    line = max(line for line, _, _ in branches)

    assert {0: "1", 1: "0"} == {branch: taken for (at, _, branch), taken in branches.items() if at == line}


def test_a_tree_in_python_has_the_lines_of_its_outline(tmp_path):
    coverage = TreeCoverage()
    steps = Selector("Steps", memory=True, children=[Failure("A"), Success("B"), Success("C")])
    coverage.watch("trees:errand", Sequence("Root", memory=True, children=[steps])).tick()
    text, outline = lcov(coverage, tmp_path / "out.outline.txt")
    (counts, _), told = parsed(text)[str(tmp_path / "out.outline.txt")], outline.splitlines()

    assert "trees:errand" == told[0]
    assert {"Sequence Root": 1, "Failure A": 1, "Success B": 1, "Success C": 0}.items() <= {
        told[line - 1].strip(): count for line, count in counts.items()
    }.items()


def test_branches_of_a_node_that_was_not_ticked_are_no_zeros():
    """As geninfo says of blocks that were not executed."""
    coverage = TreeCoverage()
    coverage.watch("trees:errand", Sequence("Root", memory=True, children=[Failure("A"), Success("B")])).tick()
    _, branches = next(iter(parsed(lcov(coverage, Path("out.outline.txt"))[0]).values()))

    assert "-" == branches[4, 0, 0]
