"""Suggestions of similar names in error messages."""

from __future__ import annotations

import pytest

from hmrsim.diagnostics import instead, shown

MANY = [f"robot{number}" for number in range(20)]


@pytest.mark.parametrize(
    ("wanted", "known", "words"),
    [
        ("kitchn", ["ward", "kitchen"], "; did you mean 'kitchen'?"),
        ("x", ["ward", "kitchen"], "; there are ward, kitchen"),
        ("x", MANY, f"; there are {', '.join(MANY[:8])} and 12 more"),
        ("x", [], "; there are none"),
    ],
)
def test_a_message_ends_with_suggestions(wanted, known, words):
    assert words == instead(wanted, known)


def test_a_long_text_is_cut():
    assert ("'short'", f"'{'x' * 60}…'") == (shown("short"), shown("x" * 1000))
