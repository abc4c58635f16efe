"""The place of an error in users' code."""

from __future__ import annotations

import json

import pytest

from hmrsim.program.users_code import place_in

PYTHON = (json.__file__, 7)
MISSION = ("/home/ada/mission.py", 3)
HELPER = ("/home/ada/helper.py", 9)


@pytest.mark.parametrize(
    ("frames", "expected"),
    [
        ([MISSION, PYTHON], "/home/ada/mission.py:3"),
        ([MISSION, HELPER, PYTHON], "/home/ada/helper.py:9"),
        ([PYTHON, (json.__file__, 8)], f"{json.__file__}:8"),
        ([], ""),
    ],
)
def test_the_place_is_the_innermost_frame_of_the_user_s_code(frames, expected):
    assert expected == place_in(frames)
