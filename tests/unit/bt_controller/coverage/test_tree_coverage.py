"""Coverages that are merged and kept."""

from __future__ import annotations

import json

import pytest
from py_trees.behaviours import Failure, Success
from py_trees.composites import Sequence

from bt_controller.coverage import CoverageError, TreeCoverage


def ticked(*children, name="trees:errand"):
    """Return the coverage of a sequence that was ticked once."""
    coverage = TreeCoverage()
    coverage.watch(name, Sequence("Root", memory=True, children=list(children))).tick()
    return coverage


def test_keys_say_what_happened():
    keys = ticked(Success("A"), Failure("B")).keys()

    assert {"trees:errand/Root/A:SUCCESS", "trees:errand/Root/B:FAILURE", "trees:errand/Root:FAILURE"} == keys


def test_merging_adds_counts():
    coverage = ticked(Success("A"))
    coverage.merge(ticked(Failure("A")))

    assert {"SUCCESS": 1, "FAILURE": 1} == coverage.nodes("trees:errand")[1].counts


def test_merging_counts_the_trees():
    coverage = ticked(Success("A"))
    coverage.merge(ticked(Success("A")))

    assert 2 == coverage.runs("trees:errand")


def test_trees_of_other_names_stay_apart():
    coverage = ticked(Success("A"))
    coverage.merge(ticked(Success("A"), name="trees:other"))

    assert ("trees:errand", "trees:other") == coverage.trees


def test_the_order_of_merging_does_not_matter():
    one, two = ticked(Success("A"), Failure("B")), ticked(Success("C"), name="another")
    ahead, behind = TreeCoverage(), TreeCoverage()
    for each in (one, two):
        ahead.merge(each)
    for each in (two, one):
        behind.merge(each)

    assert json.dumps(ahead.to_json()) == json.dumps(behind.to_json())


def test_json_is_read_as_it_was_written():
    told = ticked(Success("A"), Failure("B")).to_json()

    assert told == TreeCoverage.from_json(json.dumps(told)).to_json()


@pytest.mark.parametrize("text", ["{", "[]", "[" * 100_000, b"\xff", '{"format": "other", "trees": {}}'])
def test_other_texts_are_no_coverage(text):
    with pytest.raises(CoverageError, match=r"no coverage of trees: .*; expected a file written by --coverage"):
        TreeCoverage.from_json(text)


def test_what_is_missing_is_what_could_have_happened():
    """A leaf that only succeeds can't fail, and nothing halts it."""
    nodes = ticked(Success("A"), Failure("B")).nodes("trees:errand")

    assert [("Root", ()), ("A", ()), ("B", ())] == [(node.name, node.missing) for node in nodes]


def test_nodes_are_followed_by_those_below_them():
    coverage = ticked(Sequence("A", memory=True, children=[Success("B")]))
    coverage.merge(ticked(Sequence("C", memory=True, children=[Success("D")])))

    assert ["Root", "A", "B", "C", "D"] == [node.name for node in coverage.nodes("trees:errand")]
