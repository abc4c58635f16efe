"""Messages as text."""

from __future__ import annotations

import json

from hmrsim.cli.output import show_json, yaml_text


def test_people_see_nine_digits():
    """What binary arithmetic adds is no news; whole numbers have no such noise."""
    assert "x: 0.3\ny: 2.0\nsec: 1234567891\n" == yaml_text({"x": 0.1 + 0.2, "y": 2.0, "sec": 1_234_567_891})


def test_programs_see_all_digits(capsys):
    """JSON is exact."""
    show_json([0.1 + 0.2])

    assert [0.1 + 0.2] == json.loads(capsys.readouterr().out)
