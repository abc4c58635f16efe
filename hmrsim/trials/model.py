"""The controller under test, its world, and the limits of its runs, as files of experiments and checks name them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from hmrsim.diagnostics import shown
from hmrsim.world.model import World
from hmrsim.world.overlays.overlay import overlay_of
from hmrsim.world_checks import load_world
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from hmrsim.world.overlays.overlay import Overlay

Identifier = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=60)]


def _level(value: Any) -> Any:
    if not isinstance(value, (str, int, float)):
        raise ValueError(f"expected a number, a text, true or false, got {shown(value)}")  # noqa: TRY004 - pydantic takes no TypeError
    return value


Level = Annotated[str | int | float | bool, BeforeValidator(_level)]
"""A level of a factor, or a parameter of a controller."""


class Part(BaseModel):
    """The base class of models in files of experiments and checks: unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


_MEMORY: Final = re.compile(r"(\d+(?:\.\d+)?) ?(kB|MB|GB)")
_BYTES: Final = {"kB": 10**3, "MB": 10**6, "GB": 10**9}

Count = Annotated[int, Field(strict=True, ge=1, le=10_000_000)]
Seconds = Annotated[float, Field(strict=True, gt=0, le=1e9)]


def _bytes(value: Any) -> Any:
    match = _MEMORY.fullmatch(value) if isinstance(value, str) else None
    return int(float(match[1]) * _BYTES[match[2]]) if match else value


class Limits(Part):
    """The limits of a run.

    Attributes:
        simulated: Seconds of simulated time in which the controller has to end; if None, ten times the seconds that it
            takes without faults, plus ten minutes.
        wall: Wall seconds in which the run waits: in which it computes nothing, and could not.
        processor: Seconds of processor time; the same as *wall* if left out.
        memory: Bytes in addition to those of its worker; in a file also 500 MB or 1 GB.
    """

    simulated: Seconds | None = None
    wall: Seconds = 20.0
    processor: Seconds | None = None
    memory: Annotated[int, BeforeValidator(_bytes), Field(strict=True, ge=10**6)] | None = None


class Controller(Part):
    """A controller that is tested in trials.

    Attributes:
        tree: A behavior tree, run in the worker's process: FILE.xml, MODULE:FUNCTION or FILE.py:FUNCTION(NAME=VALUE).
        python: A function of a `hmrsim_zenoh.Client`, or a coroutine function of a `hmrsim_zenoh.AsyncClient`, run in
            the worker's process.
        command: A command line, started for each run with the endpoint of the simulator in its environment.
        set: Parameters: texts on the blackboard of a tree, arguments of a function, or environment variables of a
            command. Expressions in *tree*, *python* and *command* can use them, too.
        robots: The robots of a tree; None for all.
        nodes: Modules with further nodes for trees in XML.
        tree_id: The ID of the tree in an XML file.
        name: Its name as a participant, on which the ids of goals depend; that of the function, or ``bt_controller``,
            if left out.
    """

    tree: str | None = None
    python: str | None = None
    command: str | tuple[str, ...] | None = None
    set: dict[str, Level] = {}
    robots: tuple[str, ...] | None = None
    nodes: tuple[str, ...] = ()
    tree_id: str | None = None
    name: Identifier | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if sum(each is not None for each in (self.tree, self.python, self.command)) != 1:
            raise ValueError("expected one of tree, python and command")
        return self

    @property
    def in_process(self) -> bool:
        """True if it runs in the worker's process."""
        return self.command is None

    @property
    def participant(self) -> str:
        """The participant's name of a controller in this process."""
        function = "" if self.python is None else re.split(r"\W", self.python.rpartition(":")[2])[0]
        return self.name or function or "bt_controller"

    @property
    def described(self) -> str:
        """The controller as part of a sentence."""
        if self.command is not None:
            return f"the command {self.command if isinstance(self.command, str) else shlex.join(self.command)!r}"
        return f"the tree {self.tree!r}" if self.tree is not None else f"the code {self.python!r}"


AnyWorld = str | Path | Mapping[str, Any] | World
"""A world: the name of a shipped world, the path of a file, plain values, or a loaded world."""


def read_world(world: AnyWorld, changes: Mapping[str, Any] | None = None, overlays: Sequence[Overlay] = ()) -> World:
    """Return a world with changes, by path as with ``--overlay``, and further overlays.

    Raises:
        WorldError: The world is invalid; it has all errors.
        ValueError: There are changes to a loaded world.
    """
    overlays = [*([overlay_of(changes, "changes")] if changes else []), *overlays]
    if isinstance(world, World):
        if overlays:
            raise ValueError("a loaded world can't be changed; pass the changes with its file or its plain values")
        return world
    if isinstance(world, Mapping):
        return world_of(dict(world), "world", overlays)
    return load_world(world, overlays=overlays).world


def source_of(world: str, folder: Path) -> str:
    """Return the path of a world's file, relative to the file that names it, or the name of a shipped world."""
    beside = folder / world
    return str(beside) if beside.is_file() or Path(world).suffix else world
