"""The settings of a run: its seed, how its time moves, what is sampled and what is kept."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict

from hmrsim.settings.option import Option

MAX_PAYLOAD: Final = 1024 * 1024
"""Bytes that a payload may have unless a user says otherwise."""

TIME_STANDS: Final = "time passes only while robots do something"

_NANOSECOND: Final = 1e-9
_PARTICIPANT: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_RATE: Final[dict[str, Any]] = {"metavar": "HZ", "unit": "Hz, of simulated time", "group": "server", "more_than": 0}
_TIMEOUT: Final[dict[str, Any]] = {"metavar": "S", "unit": "wall seconds"}


def count(text: str) -> int:
    """Return a whole number greater than 0."""
    if not text.isdecimal() or int(text) == 0:
        raise ValueError(f"{text!r} is not a whole number greater than 0")
    return int(text)


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


class Settings(BaseModel):
    """What models of settings have in common."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")


class RunSettings(Settings):
    """How a world is run.

    Each field is an option of ``hmrsim run``, a variable ``HMRSIM_…`` and a key of a settings file, too. A program that
    runs a world by itself gives them to `Simulator`, which looks at the seed, the step size, the rates and how many
    results are kept; all others are about a simulation that is served.
    """

    seed: Annotated[int | None, Option("replaces the world's", "N")] = None
    clock: Annotated[
        Literal["realtime", "lockstep"],
        Option(
            "how simulated time moves: with the wall; or as far as the controllers that join allow, as fast as the "
            "machine can, and the same each time",
            group="time",
        ),
    ] = "realtime"
    real_time_factor: Annotated[
        float,
        Option(
            "simulated seconds a wall second, in real time; 0: as fast as possible",
            "X",
            group="time",
            at_least=0,
            at_most=1e6,
            hint="0 is as fast as possible",
        ),
    ] = 1.0
    participants: Annotated[
        int | tuple[str, ...],
        Option(
            "in lockstep, how many controllers have to join before time moves, or their names",
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
            "drop a controller that thinks for more than so many wall seconds; -1: never",
            group="time",
            more_than=0,
            for_ever=math.inf,
            **_TIMEOUT,
        ),
    ] = 30.0
    on_participant_loss: Annotated[
        Literal["continue", "end"], Option("whether the run goes on when a controller was dropped", group="time")
    ] = "continue"
    planner_timeout: Annotated[
        float,
        Option(
            "wall seconds that an external planner may take for a path, while time stands in lockstep; -1: for ever",
            group="time",
            more_than=0,
            for_ever=math.inf,
            **_TIMEOUT,
        ),
    ] = 5.0
    step_size: Annotated[
        float,
        Option(
            "what one step is, for step_simulation and simulate_steps",
            "SIM_S",
            unit="simulated seconds",
            group="time",
            more_than=0,
            check=_check_step,
        ),
    ] = 0.1
    duration: Annotated[
        float,
        Option(
            f"end after so much simulated time; with --real-time-factor 0 {TIME_STANDS}",
            "SIM_S",
            unit="simulated seconds",
            group="time",
            more_than=0,
            endless=True,
        ),
    ] = math.inf
    feedback_rate: Annotated[float, Option("samples of feedback a simulated second", **_RATE)] = 10.0
    odom_rate: Annotated[float, Option("samples of odom a simulated second", **_RATE)] = 10.0
    clock_rate: Annotated[float, Option("samples of clock a simulated second", **_RATE)] = 10.0
    detection_rate: Annotated[float, Option("samples of detection a simulated second", **_RATE)] = 10.0
    battery_rate: Annotated[float, Option("samples of battery a simulated second", **_RATE)] = 1.0
    result_timeout: Annotated[
        float,
        Option(
            "wall seconds that a result is kept; -1: for ever",
            group="server",
            at_least=0,
            for_ever=-1.0,
            hint="-1 is for ever",
            **_TIMEOUT,
        ),
    ] = 900.0
    keep_results: Annotated[
        int, Option("results of ended goals that are kept of a robot", "N", group="server", more_than=0, read=count)
    ] = 1000
    max_payload: Annotated[
        int,
        Option("refuse requests that are larger", "BYTES", unit="bytes", group="server", more_than=0, read=count),
    ] = MAX_PAYLOAD


class SimulateSettings(RunSettings):
    """How ``hmrsim simulate`` runs a world: to the end of its scripts."""

    duration: Annotated[
        float, Option("give up after so much time", "SIM_S", unit="simulated seconds", more_than=0, endless=True)
    ] = math.inf
    keep_results: int = 1
    """No client asks for results there."""


class DemoSettings(RunSettings):
    """How ``hmrsim demo`` runs its world: it has to come to an end."""

    real_time_factor: Annotated[
        float, Option("simulated seconds a wall second, in real time", "X", group="time", more_than=0, at_most=1e6)
    ] = 10.0
