"""The check of the documentation's prose."""

from __future__ import annotations

from tools.prose import flaws_of


def test_a_phrase_is_told_with_its_line_and_what_would_do():
    text = "# Title\n\nA goal is cancelled.\n\n| a | b |\n|---|---|\n| `just` | easily done |\n"

    assert [(3, "cancelled"), (7, "easily")] == [(line, flaw.split("'")[1]) for line, flaw in flaws_of(text)]
