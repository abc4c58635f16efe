"""The reader of pages finds their errors."""

from __future__ import annotations

import pytest

from hmrsim.errors import HmrsimError
from tests.docs.page import blocks_of
from tests.docs.session import Session
from tests.docs.transcript import fits


@pytest.fixture
def do(tmp_path):
    """Return the function that follows a page, with `~` for the ticks of its fences."""

    def do(text):
        """Return the function that follows a page, with `~` for the ticks of its fences."""
        page = tmp_path / "page.md"
        page.write_text(text.replace("~~~", "```"))
        (tmp_path / "folder").mkdir()
        with Session(tmp_path / "folder", tmp_path / "files") as session:
            for block in blocks_of(page):
                session.do(block)
            session.end()
        return session

    return do


RIGHT = {
    "the output of a command": "~~~console\n$ echo a; echo b\na\nb\n~~~",
    "some of it": "~~~console\n$ seq 9\n1\n...\n9\n~~~",
    "a command of two lines": "~~~console\n$ for i in 1 2; do\n>   echo $i\n> done\n1\n2\n~~~",
    "a command that fails": "<!-- exit: 3 -->\n~~~sh\nexit 3\n~~~",
    "the output of Python": "~~~python\nprint(2)\n~~~\n\n<!-- output -->\n~~~text\n2\n~~~",
    "a name from block to block": "~~~python\nx = 2\n~~~\n\n~~~pycon\n>>> x\n2\n~~~",
    "a file": '~~~python title="mine.py"\nX = 3\n~~~\n\n~~~python\nfrom mine import X\nassert X == 3\n~~~',
    "a variable": "~~~sh\nexport WHO='you and me'\ntest \"$WHO\" = 'you and me'\n~~~",
    "another terminal": "<!-- background -->\n~~~console\n$ echo up; sleep 60\nup\n~~~\n\n~~~sh\ntrue\n~~~",
    "a stand-in": "<!-- stand in: 500 = 1 -->\n\n~~~console\n$ echo 500\n1\n~~~",
    "a test": "~~~python\ndef test_it():\n    assert True\n~~~",
    "progress that no page shows": (
        "~~~console\n$ printf 'searching: 3 runs\\nreducing a failure of a: 1 run\\n1 of 2 runs (50%%)\\nb\\n'\nb\n~~~"
    ),
    "a world": "<!-- world -->\n~~~yaml\nname: a\nwaypoints: {home: [0, 0]}\n~~~",
    "an extra": "~~~sh\npip install 'hmrsim[gym]'\n~~~",
}
WRONG = {
    "other output": ("~~~console\n$ echo a\nb\n~~~", "printed instead:\na"),
    "too much output": ("~~~console\n$ seq 3\n1\n2\n~~~", "printed instead:\n1"),
    "another exit code": ("~~~sh\nfalse\n~~~", "ended with 1"),
    "a success that should not be": ("<!-- exit: 1 -->\n~~~sh\ntrue\n~~~", "ended with 0"),
    "an error in Python": ("~~~python\n1 / 0\n~~~", "division by zero"),
    "other output of Python": ("~~~python\nprint(1)\n~~~\n\n<!-- output -->\n~~~text\n2\n~~~", "printed instead:\n1"),
    "a wrong doctest": ("~~~pycon\n>>> 1 + 1\n3\n~~~", "Expected:\n    3"),
    "a test that fails": ("~~~python\ndef test_it():\n    assert False\n~~~", "1 failed"),
    "a block of no kind": ("~~~yaml\na: 1\n~~~", "needs a comment that says what it is"),
    "a comment that means nothing": ("<!-- wurld -->\n~~~yaml\na: 1\n~~~", "nothing is known of the comment 'wurld'"),
    "a wrong world": ("<!-- world -->\n~~~yaml\nname: a\nwaypoints: {home: [0]}\n~~~", "home"),
    "lines that are in no file": ("<!-- part of: Makefile -->\n~~~text\nnot there\n~~~", "not in Makefile"),
    "a terminal that never says so": (
        "<!-- background -->\n~~~console\n$ echo down\nup\n~~~",
        "printed instead:\ndown",
    ),
    "no such extra": ("~~~sh\npip install 'hmrsim[gin]'\n~~~", "no extra {'gin'}"),
    "no such target": ("~~~sh\nmake tea\n~~~", "No rule to make target"),
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_correct_page_passes(do, name):
    do(RIGHT[name])


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_block_is_reported_with_the_real_output(do, name):
    text, message = WRONG[name]

    with pytest.raises((AssertionError, ArithmeticError, HmrsimError, ValueError)) as raised:
        do(text)

    assert message in str(raised.value)


def test_a_block_that_needs_a_missing_program_is_skipped(do):
    assert ["line 2 needs no_such_program"] == do("<!-- needs: no_such_program -->\n~~~sh\nfalse\n~~~").skipped


def test_dots_stand_for_anything():
    assert fits("a ... c\n...\ne", "a b c\nd\nd\ne")
    assert not fits("a.c", "abc")
