"""A small sample of what `python -m tests.torture.files` tries by the ten thousand."""

from __future__ import annotations

import pytest

from tests.torture.corpus import samples
from tests.torture.files import case, findings

KINDS = ("world", "tree", "trace", "recording", "settings", "coverage", "properties")


@pytest.mark.uncovered
def test_damaged_files_are_read_or_refused():
    assert [] == list(findings(seed=0, count=100))


def test_a_case_follows_from_its_seed_and_number():
    assert case(7, 3).content == case(7, 3).content
    assert case(7, 3).content != case(7, 4).content


def test_there_are_files_of_each_kind():
    assert {*KINDS} == {sample.kind for sample in samples()}
