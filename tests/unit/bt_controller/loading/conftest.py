"""Trees in files, made of a few nodes that do next to nothing."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.blackboards import Board
from bt_controller.core.node import Control, Decoration, Leaf
from bt_controller.core.ports import ANY, DOUBLE, INT, POSE, STRING, input_port, output_port
from bt_controller.loading.file_tree import load_file
from bt_controller.nodes import registry

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour


class All(Control):
    """A control that ticks all its children."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        for child in self.children:
            yield from child.tick()
        return Status.SUCCESS


class Two(All):
    """A control with exactly two children."""

    least = most = 2


class Same(Decoration):
    """A decorator that returns the status of its child."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        return (yield from self.tick_child())


class Say(Leaf):
    """A leaf whose message is the text that it reads."""

    INPUTS: ClassVar = {"text": input_port(STRING, default="nothing")}

    def update(self) -> Status:
        self.feedback_message = self.read("text")
        return Status.SUCCESS


class Go(Leaf):
    """A leaf with a required goal."""

    INPUTS: ClassVar = {
        "goal": input_port(POSE),
        "speed": input_port(DOUBLE, default=1.0),
        "note": input_port(ANY, default="{note}"),
    }
    OUTPUTS: ClassVar = {"code": output_port(INT), "where": output_port(POSE)}

    def update(self) -> Status:
        self.write("code", 7)
        return Status.SUCCESS


class Put(Leaf):
    """A leaf that writes an entry."""

    INPUTS: ClassVar = {"value": input_port(ANY)}
    OUTPUTS: ClassVar = {"to": output_port(ANY)}
    KEYS: ClassVar = ("to",)

    def update(self) -> Status:
        self.write("to", self.read("value"))
        return Status.SUCCESS


NODES = {"All": All, "Two": Two, "Same": Same, "Say": Say, "Go": Go, "Put": Put}


class Files:
    """A folder with files of trees.

    Attributes:
        nodes: The nodes that they may use.
        unset: The blackboard keys that the last loaded tree lacked.
        doubts: The warnings about the last loaded tree.
    """

    def __init__(self, folder):
        self.folder = folder
        self.nodes = {**NODES, "Script": registry()["Script"]}
        self.unset = self.doubts = ()

    def write(self, text, name="tree.xml"):
        """Write a file into the folder; without <root>, that is put around."""
        whole = text if text.lstrip().startswith(("<root", "<?", "<!")) else f'<root BTCPP_format="4">{text}</root>'
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(whole, encoding="utf-8")
        return str(path)

    def load(self, text, *, tree=None, values=None):
        found, self.unset, self.doubts = load_file(self.write(text), self.nodes, tree=tree, values=values or {})
        return found

    def read(self, name="tree.xml"):
        found, self.unset, self.doubts = load_file(name, self.nodes, tree=None, values={})
        return found

    @contextmanager
    def built(self, text, **options):
        """Give the root of a tree, while its blackboard is in use."""
        found = self.load(text, **options)
        with Board().in_use:
            for key, value in (options.get("values") or {}).items():
                Blackboard.set(key, value)
            yield found.build()

    def ticked(self, text, **options):
        """Return what is on the blackboard after a tick, by key, and what the nodes say, by name."""
        with self.built(text, **options) as root:
            for node in root.iterate():
                node.setup()
            root.tick_once()
            entries = {key: value for key, value in Blackboard.storage.items() if "__const" not in key}
            return entries, {node.name: node.feedback_message for node in root.iterate() if node.feedback_message}


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Return a folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    return Files(Path())
