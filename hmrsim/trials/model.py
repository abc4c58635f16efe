"""The model of a controller under test, as files of experiments and of checks have it."""

from __future__ import annotations

import shlex
from typing import Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from hmrsim.diagnostics import shown

Identifier = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=60)]


def _level(value: Any) -> Any:
    if not isinstance(value, (str, int, float)):
        raise ValueError(f"expected a number, a text, true or false, got {shown(value)}")  # noqa: TRY004 - pydantic takes no TypeError
    return value


Level = Annotated[str | int | float | bool, BeforeValidator(_level)]
"""A level of a factor, or a parameter of a controller."""


class Part(BaseModel):
    """A part of a file that names controllers: unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Controller(Part):
    """A controller under test.

    Attributes:
        tree: A behavior tree, run in the worker's process: FILE.xml, MODULE:FUNCTION or FILE.py:FUNCTION(NAME=VALUE).
        python: A function that is given a `hmrsim_zenoh.Client`, or a coroutine function that is given a
            `hmrsim_zenoh.AsyncClient`, in the same process.
        command: A command line; it is started for each run, with its own endpoint in its environment.
        set: Parameters: texts on the blackboard of a tree, arguments of a function, variables of a command's
            environment. Expressions in *tree*, *python* and *command* may ask for them, too.
        robots: The robots of a tree; None for all.
        nodes: Modules with further nodes for trees in XML.
        tree_id: Which tree of an XML file.
        name: Under which name it takes part; goals' ids depend on it.
    """

    tree: str | None = None
    python: str | None = None
    command: str | tuple[str, ...] | None = None
    set: dict[str, Level] = {}
    robots: tuple[str, ...] | None = None
    nodes: tuple[str, ...] = ()
    tree_id: str | None = None
    name: Identifier = "bt_controller"

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
    def described(self) -> str:
        """The controller as part of a sentence."""
        if self.command is not None:
            return f"the command {self.command if isinstance(self.command, str) else shlex.join(self.command)!r}"
        return f"the tree {self.tree!r}" if self.tree is not None else f"the code {self.python!r}"
