"""Run control: time advances while the simulation plays, stands while it is paused, and can advance by steps.

The gate is also the server of the actions of ``_world``, which the world serves and no robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.environment import Tick
from hmrsim.engine.sim_time import nanoseconds
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import SimulationState
from hmrsim.protocol.goal import WORLD, GoalStatus

if TYPE_CHECKING:
    import simpy

    from hmrsim.engine.environment import Environment


class Gate:
    """Limits how far time may advance.

    Args:
        step_size: Simulated seconds of one step; whole nanoseconds, at least one.
        hindrance: Returns why time does not move although the gate is open; empty if it moves.

    Attributes:
        limit: Up to this time; infinite while the simulation plays.
        state: Whether it plays, is paused or stopped, by the numbers of SimulationState. It is paused during steps.
        stepping: Whether steps are being made.
        name: The world's, where a robot has its name.
        components: Always None.
        disabled_reasons: Always empty.
    """

    name: Final = WORLD
    components: Final[Mapping[str, Any]] = MappingProxyType({})
    disabled_reasons: Final[Mapping[str, str]] = MappingProxyType({})

    def act(
        self, action: str, ended: GoalStatus | None = None, *, holds: bool = True, in_real_time: bool = False
    ) -> None:
        """Do nothing: the control needs no events of goals."""

    def __init__(self, env: Environment, step_size: float, hindrance: Callable[[], str] = lambda: "") -> None:
        if nanoseconds(step_size) < 1:
            raise ValueError(f"the step size must be a nanosecond at least, got {step_size} s")
        self._env = env
        self.step_size = step_size
        self._step = nanoseconds(step_size)
        self.limit = math.inf
        self.state = SimulationState.STATE_PLAYING
        self.stepping = False
        self.hindrance = hindrance
        self._began = 0
        self._waiting: Callable[[str], None] | None = None

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self._env.now

    def why_no_steps(self) -> str | None:
        """Return why no steps can be made now; None if they can."""
        if self.state != SimulationState.STATE_PAUSED:
            return "the simulation is not paused; pause it first"
        return "steps are being made already; wait for their end" if self.stepping else None

    def set(self, state: int, why: str) -> None:
        """Start or stop time; steps that are being made end now, for the reason *why*."""
        self.state = state
        self.shut()
        self.halt(why)

    def halt(self, why: str) -> None:
        """End the steps in progress, if a client waits for any, with the reason *why*."""
        if self._waiting is not None:
            waiting, self._waiting = self._waiting, None
            self.shut()
            waiting(why)

    def open(self, steps: int) -> None:
        """Start time for a number of steps; call `shut` at their end."""
        self.stepping = True
        self._began = nanoseconds(self._env.now)
        self.limit = self._end(steps)

    def shut(self) -> None:
        """Stop time again, unless the simulation plays."""
        self.stepping = False
        self.limit = math.inf if self.state == SimulationState.STATE_PLAYING else self._env.now

    def step_end(self, number: int) -> Tick:
        """Return the event at the end of a step, counted from 1, which comes after all others of its instant."""
        return Tick(self._env, self._end(number))

    def make_steps(self, number: int, done: Callable[[str], None]) -> None:
        """Advance time by a number of steps, then call *done* with the reason why some are missing, or ""."""
        self.open(number)
        end, self._waiting = self.step_end(number), done

        def at_end(_event: simpy.Event) -> None:
            # The caller that has ended these steps early may have started others.
            if self._waiting is done:
                self.halt("")

        end.callbacks = [at_end]

    def _end(self, steps: int) -> float:
        return (self._began + steps * self._step) / NANOSECONDS
