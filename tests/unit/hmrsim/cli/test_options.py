"""Number options reject values that no run could use, in one line."""

from __future__ import annotations

import pytest

from hmrsim.cli import main

WALL_SECONDS = ["--participant-timeout", "--planner-timeout", "--result-timeout", "--timeout"]
RATES = ["--feedback-rate", "--odom-rate", "--clock-rate", "--detection-rate", "--battery-rate"]
OPTIONS = [
    *(f"run scenario1 {option}" for option in (*WALL_SECONDS, *RATES, "--step-size", "--keep-results")),
    "run scenario1 --max-payload",
    "run scenario1 --real-time-factor",
    "simulate scenario1 --seed",
    "action list --timeout",
    "topic hz /wall_e/odom --window",
    "record run.mcap --duration",
    "view --port",
    "map render scenario1 --width",
    "map render scenario1 --scale",
    "map plan scenario1 a b --speed",
    "demo --real-time-factor",
]


@pytest.mark.parametrize("option", OPTIONS)
def test_numbers_that_no_run_could_use(option, capsys):
    """Numbers that are too large, too long, not finite or not numbers are wrong use."""
    for text in ("1e308", "nan", "inf", "-inf", "1" + "0" * 5_000, "x", "", "\x1b[2J"):
        code = main([*option.split(), text])
        told = capsys.readouterr()

        assert (2, 1, "") == (code, told.err.count("\n"), told.out), (text, told.err)
        assert "\x1b" not in told.err
