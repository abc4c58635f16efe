"""Checks of a simulator from its clients' view."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final

import hmrsim
from hmrsim_zenoh.doctor.snapshot import Problem, first_few

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Simulator, Snapshot

_PLANNER: Final = "_planner"
"""The external planner's name in ``waiting_for``."""


def twins(simulator: Simulator) -> Iterator[Problem]:
    """Report other simulators with the same prefix."""
    if simulator.twins:
        yield Problem(
            "two_simulators",
            f"{len(simulator.twins) + 1} simulators have the same prefix: a request may reach any of them, or all",
            "end one of them, or start it with another --prefix",
        )


def contract(simulator: Simulator) -> Iterator[Problem]:
    """Report that the simulator and this program have different contracts."""
    theirs = simulator.info.get("contract")
    if theirs != hmrsim.CONTRACT:
        yield Problem(
            "contract",
            f"the simulator (hmrsim {simulator.info.get('hmrsim')}) has contract {theirs}, this hmrsim "
            f"{hmrsim.__version__} has contract {hmrsim.CONTRACT}",
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
            f"{first_few(idle)} can do nothing: there are no actions",
            "give a base or other components in the world file",
        )


def tokens(simulator: Simulator) -> Iterator[Problem]:
    """Report robots without a liveliness token."""
    if simulator.lost:
        are = "is" if len(simulator.lost) == 1 else "are"
        yield Problem(
            "no_token",
            f"{first_few(simulator.lost)} {are} unreachable: there is no liveliness token, and goals are rejected",
            "list faults with `hmrsim service call /_world/get_faults`; /_world/clear_fault clears one",
        )


def time_stands(simulator: Simulator) -> Iterator[Problem]:
    """Report why time stands still."""
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
            f"{stands}: the external planner has not answered yet",
            "check the planner; the goal is aborted after --planner-timeout",
        )
    elif set(awaited) <= set(time.get("participants", ())):
        yield Problem(
            "time_stands",
            f"{stands}, for {simulator.watched:.1g} s at least: waiting for {first_few(awaited)} to advance",
            "check these participants; they are dropped after --participant-timeout",
        )
    else:
        here = time.get("participants", ())
        # "2 to join" stands for participants without known names.
        joining = (name.removesuffix(" to join") for name in awaited if name not in here)
        yield Problem(
            "time_stands",
            f"{stands}: waiting for {first_few(joining)} to join in lockstep",
            "start a controller, such as `bt-controller run TREE --robot NAME --name PARTICIPANT`, or run with "
            "`--clock realtime`",
        )


def lag(simulator: Simulator) -> Iterator[Problem]:
    """Report that the machine can't keep up."""
    lags = [time.get("lag", 0.0) for time in simulator.times]
    if lags and lags[-1] > lags[0]:
        yield Problem(
            "lag",
            f"the machine can't keep up: simulated time lags by {lags[-1]:.1f} wall seconds, and the lag grows",
            "lower --real-time-factor, or reduce robots, rates or subscribers",
        )


def planner(simulator: Simulator) -> Iterator[Problem]:
    """Report robots whose goals are rejected as the external planner is missing."""
    waiting = [robot["name"] for robot in simulator.info.get("robots", ()) if robot.get("planner") == "external"]
    if waiting and not simulator.info.get("planner_present"):
        yield Problem(
            "no_planner",
            f"{first_few(waiting)} {'needs' if len(waiting) == 1 else 'need'} an external planner, but there is none",
            "start one; see `An external planner` in docs/reference/keys.md",
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
