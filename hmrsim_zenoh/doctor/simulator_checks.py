"""Checks of a simulator from its clients' view."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import hmrsim
from hmrsim_zenoh.doctor.problem import Problem, some

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hmrsim_zenoh.doctor.snapshot import Simulator, Snapshot

_PLANNER: Final = "_planner"
"""Stands among whom time waits for."""


def twins(simulator: Simulator) -> Iterator[Problem]:
    """Tell that others answer on the same keys."""
    if simulator.twins:
        yield Problem(
            "two_simulators",
            f"{len(simulator.twins) + 1} simulators have the same prefix: a request may reach any of them, or all",
            "end one of them, or start it with another --prefix",
        )


def contract(simulator: Simulator) -> Iterator[Problem]:
    """Tell that simulator and tools mean different things by the same key."""
    theirs = simulator.info.get("contract")
    if theirs != hmrsim.CONTRACT:
        yield Problem(
            "contract",
            f"the simulator (hmrsim {simulator.info.get('hmrsim')}) keeps contract {theirs}, this hmrsim "
            f"{hmrsim.__version__} contract {hmrsim.CONTRACT}",
            "install the same version on both sides",
        )


def robots(simulator: Simulator) -> Iterator[Problem]:
    """Report that the simulator has no robots."""
    if not simulator.robots:
        yield Problem("no_robots", "the world has no robots", "add one: `hmrsim run WORLD --robot NAME@X,Y`")
    idle = [robot for robot, actions in simulator.robots.items() if not actions]
    if idle:
        yield Problem(
            "no_actions",
            f"{some(idle)} can do nothing: no action is served",
            "give a base or other components in the world file",
        )


def tokens(simulator: Simulator) -> Iterator[Problem]:
    """Tell of robots that a controller takes for lost."""
    if simulator.lost:
        are = "is" if len(simulator.lost) == 1 else "are"
        yield Problem(
            "no_token",
            f"{some(simulator.lost)} {are} out of reach: no liveliness token, and goals are rejected",
            "if it is a fault, it is in `hmrsim service call /_world/get_faults`, and /_world/clear_fault ends it",
        )


def time_stands(simulator: Simulator) -> Iterator[Problem]:
    """Tell why time does not move."""
    time = simulator.time
    if time.get("paused"):
        yield Problem(
            "paused",
            f"time stands at {time.get('now'):.9g} s: it is paused",
            "`hmrsim service call /_world/set_simulation_state '{state: {state: 1}}'`",
        )
        return
    awaited = list(time.get("waiting_for", ()))
    if not awaited or any(each.get("now") != time.get("now") for each in simulator.times):
        return
    stands = f"time stands at {time.get('now'):.9g} s"
    if _PLANNER in awaited:
        yield Problem(
            "time_stands",
            f"{stands}: an external planner has yet to answer",
            "see what keeps it; the goal ends after --planner-timeout",
        )
    elif set(awaited) <= set(time.get("participants", ())):
        yield Problem(
            "time_stands",
            f"{stands}, for {simulator.watched:.1g} s at least: {some(awaited)} yet to ask to advance",
            "see what keeps them; they are dropped after --participant-timeout",
        )
    else:
        here = time.get("participants", ())
        # A number of those whose names are not known says itself what they have to do.
        joining = (name.removesuffix(" to join") for name in awaited if name not in here)
        yield Problem(
            "time_stands",
            f"{stands}: {some(joining)} yet to join in lockstep",
            "start a controller, such as `bt-controller run TREE --robot NAME --name PARTICIPANT`, or run with "
            "`--clock realtime`",
        )


def lag(simulator: Simulator) -> Iterator[Problem]:
    """Tell that the machine can't keep up."""
    lags = [time.get("lag", 0.0) for time in simulator.times]
    if lags and lags[-1] > lags[0]:
        yield Problem(
            "lag",
            f"the machine can't keep up: time has lost {lags[-1]:.1f} wall seconds, and loses more",
            "lower --real-time-factor, or have fewer robots, rates or listeners",
        )


def planner(simulator: Simulator) -> Iterator[Problem]:
    """Report robots whose goals are rejected as the external planner is missing."""
    waiting = [robot["name"] for robot in simulator.info.get("robots", ()) if robot.get("planner") == "external"]
    if waiting and not simulator.info.get("planner_present"):
        yield Problem(
            "no_planner",
            f"{some(waiting)} {'has' if len(waiting) == 1 else 'have'} an external planner, and there is none",
            "start one; see `An external planner` in docs/keys.md",
        )


_OF_SIMULATORS: Final[tuple[Callable[[Simulator], Iterator[Problem]], ...]] = (
    twins,
    contract,
    robots,
    tokens,
    planner,
    time_stands,
    lag,
)


def _all(snapshot: Snapshot) -> Iterator[Problem]:
    if snapshot.simulator is not None:
        for check in _OF_SIMULATORS:
            yield from check(snapshot.simulator)


CHECKS: Final = (_all,)
