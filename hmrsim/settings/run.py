"""The settings of a run: its world, seed, time, sampling, server and trace; and the files that have them."""

from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, create_model

from hmrsim.errors import SettingsError
from hmrsim.interfaces.quantities import REAL_TIME_FACTOR
from hmrsim.settings.option import MAX_COUNT, MAX_PAYLOAD, MAX_SECONDS, Option, count, hints, settings_of

TIME_STANDS: Final = "time advances only while robots are active"

_NANOSECOND: Final = 1e-9
_PARTICIPANT: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_RATE: Final[dict[str, Any]] = {
    "metavar": "HZ",
    "unit": "Hz, of simulated time",
    "group": "server",
    "more_than": 0,
    "at_most": 1e6,
}
_TIMEOUT: Final[dict[str, Any]] = {"metavar": "S", "unit": "wall seconds", "at_most": MAX_SECONDS}


class Settings(BaseModel):
    """The base of models of settings."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", defer_build=True)


def _participants(text: str) -> int | tuple[str, ...]:
    return count(text) if text.isdecimal() else tuple(name.strip() for name in text.split(","))


def _check_participants(value: int | tuple[str, ...]) -> int | tuple[str, ...]:
    if isinstance(value, int):
        return value
    if not value or not all(_PARTICIPANT.fullmatch(name) for name in value):
        raise ValueError(f"{','.join(value)!r} is neither a number nor names such as nurses,porters")
    return tuple(dict.fromkeys(value))


def _check_step(value: float) -> float:
    if value < _NANOSECOND:
        raise ValueError(f"{value:g} s is less than a nanosecond")
    return value


def _existing_folder(path: Path | None) -> Path | None:
    if path is None:
        return None
    try:
        found = path.resolve(strict=True)
    except (OSError, ValueError, RuntimeError):
        found = None
    if found is None or not found.is_dir():
        raise ValueError(f"{str(path)!r} is not a folder")
    return found


class RunSettings(Settings):
    """The settings of a run.

    Each field is an option of ``hmrsim run``, a variable ``HMRSIM_…`` and a key of a settings file. A program that runs
    a world by itself passes them to `Simulator`, which uses the seed, the step size, the rates, ``keep_results``,
    ``allow_files`` and ``strict``. The others concern a simulation that is served.
    """

    seed: Annotated[int | None, Option("seed of all random numbers; overrides the world's", "N")] = None
    clock: Annotated[
        Literal["realtime", "lockstep"],
        Option(
            "realtime: simulated time follows the wall clock; lockstep: it advances as far as the participating "
            "controllers allow, as fast as possible, and every run is the same",
            group="time",
        ),
    ] = "realtime"
    real_time_factor: Annotated[
        float,
        Option(
            "simulated seconds per wall second, in real time; 0: as fast as possible",
            "X",
            group="time",
            at_least=0,
            at_most=1e6,
            hint="0 is as fast as possible",
            check=REAL_TIME_FACTOR.checked,
        ),
    ] = 1.0
    participants: Annotated[
        int | tuple[str, ...],
        Option(
            "in lockstep, the controllers that must join before time advances: their number or their names",
            "N|NAME,…",
            group="time",
            more_than=0,
            read=_participants,
            check=_check_participants,
        ),
    ] = 1
    participant_timeout: Annotated[
        float,
        Option(
            "in lockstep, wall seconds after which a controller that does not ask to advance is dropped; -1: never",
            group="time",
            more_than=0,
            for_ever=math.inf,
            **_TIMEOUT,
        ),
    ] = 30.0
    on_participant_loss: Annotated[
        Literal["continue", "end"],
        Option("whether the run continues or ends when a controller is dropped", group="time"),
    ] = "continue"
    planner_timeout: Annotated[
        float,
        Option(
            "wall seconds that an external planner may take for a path, while simulated time waits in lockstep; "
            "-1: no limit",
            group="time",
            more_than=0,
            for_ever=math.inf,
            **_TIMEOUT,
        ),
    ] = 5.0
    step_size: Annotated[
        float,
        Option(
            "length of one step of step_simulation and simulate_steps",
            "SIM_S",
            unit="simulated seconds",
            group="time",
            more_than=0,
            at_most=MAX_SECONDS,
            check=_check_step,
        ),
    ] = 0.1
    duration: Annotated[
        float,
        Option(
            f"end after this much simulated time; with --real-time-factor 0 {TIME_STANDS}",
            "SIM_S",
            unit="simulated seconds",
            group="time",
            more_than=0,
            endless=True,
        ),
    ] = math.inf
    feedback_rate: Annotated[float, Option("feedback samples per simulated second", **_RATE)] = 10.0
    odom_rate: Annotated[float, Option("odom samples per simulated second", **_RATE)] = 10.0
    clock_rate: Annotated[float, Option("clock samples per simulated second", **_RATE)] = 10.0
    detection_rate: Annotated[float, Option("detection samples per simulated second", **_RATE)] = 10.0
    battery_rate: Annotated[float, Option("battery samples per simulated second", **_RATE)] = 1.0
    result_timeout: Annotated[
        float,
        Option(
            "wall seconds for which a result is kept; -1: no limit",
            group="server",
            at_least=0,
            for_ever=-1.0,
            hint="-1 is for ever",
            **_TIMEOUT,
        ),
    ] = 900.0
    keep_results: Annotated[
        int,
        Option(
            "results of ended goals that are kept per robot",
            "N",
            group="server",
            more_than=0,
            at_most=MAX_COUNT,
            read=count,
        ),
    ] = 1000
    max_payload: Annotated[
        int,
        Option(
            "reject larger requests", "BYTES", unit="bytes", group="server", more_than=0, at_most=MAX_COUNT, read=count
        ),
    ] = MAX_PAYLOAD
    allow_files: Annotated[
        Path | None,
        Option(
            "let clients load worlds from files of this folder by load_world",
            "DIR",
            group="server",
            default_text="shipped worlds and text only",
            check=_existing_folder,
        ),
    ] = None
    strict: Annotated[
        bool, Option("end the run when a plug-in raises an error; by default only its goal ends", group="server")
    ] = False
    run_id: str = ""
    """The identity of the run in ``_world/info``. In real time it is also part of the goal ids that the simulator
    creates, so that they differ from those of other runs. Empty for a run that its world and seed identify."""

    @property
    def goal_id_salt(self) -> str:
        """A part of the goal ids that the simulator creates, besides the seed; empty in lockstep."""
        return self.run_id if self.clock == "realtime" else ""


class SimulateSettings(RunSettings):
    """The settings of ``hmrsim simulate``, which runs a world to the end of its scripts."""

    duration: Annotated[
        float,
        Option("give up after this much simulated time", "SIM_S", unit="simulated seconds", more_than=0, endless=True),
    ] = math.inf
    keep_results: int = 1
    """No client requests results."""


class DemoSettings(RunSettings):
    """The settings of ``hmrsim demo``, whose clock can't run as fast as possible."""

    real_time_factor: Annotated[
        float, Option("simulated seconds per wall second, in real time", "X", group="time", at_least=1e-6, at_most=1e6)
    ] = 10.0


class WorldSettings(Settings):
    """The settings for reading a world file, and additions to it."""

    robot: Annotated[tuple[str, ...], Option("add a robot; repeatable", "NAME@X,Y[:TYPE]", group="world")] = ()
    item: Annotated[tuple[str, ...], Option("add an item; repeatable", "NAME@X,Y[:KG]", group="world")] = ()
    overlay: Annotated[
        tuple[str, ...], Option("apply the changes in an overlay file to the world; repeatable", "FILE", group="world")
    ] = ()
    set: Annotated[
        tuple[str, ...],
        Option(
            "change one value of the world, such as robots.*.base.speed=0.8; ~PATH removes an entry; repeatable",
            "PATH=VALUE",
            group="world",
        ),
    ] = ()
    page: Annotated[
        str | None,
        Option(
            "the page of a drawing, the level of a building or the layout of a LIF file: its name, or its number from "
            "1 (the first page; all levels, all layouts)",
            "PAGE",
            group="world",
        ),
    ] = None
    rename: Annotated[tuple[str, ...], Option("rename a robot of a drawing; repeatable", "OLD=NEW", group="world")] = ()
    lenient: Annotated[bool, Option("ignore objects of a drawing whose type is unknown", group="world")] = False
    neighbours: Annotated[
        Literal[4, 8] | None, Option("neighbors of a grid cell: 4, or 8 including diagonals", group="world")
    ] = None


class TraceSettings(Settings):
    """The settings of a run's trace."""

    trace: Annotated[Path | None, Option("write a trace of the run as lines of JSON, for `hmrsim replay`", "FILE")] = (
        None
    )


@cache
def together(models: tuple[type, ...]) -> type[BaseModel]:
    """Return one model with the settings of several."""
    # Some models are dataclasses, so that tools need not load pydantic.
    fields: dict[str, Any] = {}
    for model in models:
        for name, setting in settings_of(model).items():
            fields[name] = (hints(model)[name], setting.default)
    config = ConfigDict(strict=True, extra="forbid", frozen=True)
    return create_model("Settings", __config__=config, __doc__="Settings of `hmrsim run`.", **fields)


def read_file(path: Path, models: tuple[type, ...]) -> dict[str, Any]:
    """Return the settings of a file, YAML or JSON, by name.

    *models* declare the settings that the file may have.

    Raises:
        SettingsError: The file can't be read, or a setting is invalid; it has all problems.
    """
    # Loads yaml, which the options of commands don't need.
    from hmrsim.documents.document import read_document  # noqa: PLC0415

    document = read_document(path, SettingsError)
    if document.data is None:
        return {}
    document.check_mapping("a mapping with settings such as clock: lockstep")
    settings = document.validated(together(models))
    return {name: getattr(settings, name) for name in document.data}
