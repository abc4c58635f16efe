"""The check for functions that are set on objects after their construction."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tools.late_attributes import late


def told(code):
    """Return the findings about a module."""
    return [line.partition(";")[0] for line in late({Path("m.py"): ast.parse(code)})]


def test_a_function_that_a_class_declares_and_never_has():
    assert ["m.py:2: Server.submit is to be set by others"] == told("class Server:\n  submit: Callable[[], None]\n")


def test_a_function_that_stands_in_for_another():
    """A lambda in the constructor, and an assignment elsewhere."""
    code = "class Gate:\n  def __init__(self):\n    self.why = lambda: ''\ndef pace(gate):\n  gate.why = print\n"

    assert ["m.py:5: gate.why is set from outside"] == told(code)


@pytest.mark.parametrize(
    "code",
    [
        "class Sink(Protocol):\n  emit: Callable[[], None]\n",
        "@dataclass\nclass Leaf:\n  act: Callable[[], None]\n",
        "class Host:\n  act: Callable[[], None]\n  def __init__(self, act):\n    self.act = act\n",
        "class Gate:\n  def __init__(self):\n    self.why = lambda: ''\n  def end(self):\n    self.why = print\n",
        "def end(goal):\n  goal.status = 4\n",
    ],
    ids=["a protocol", "a record", "its own", "set by itself", "no function"],
)
def test_what_may_be(code):
    """Records, and what a class does to itself."""
    assert [] == told(code)
