"""A controller in this process that is run to its end, while it and its wire are disturbed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.judging.labels import CRASHED, HUNG
from hmrsim.experiments.running.controlling import FAILED, SUCCEEDED, TimeLimit
from hmrsim.fault_search.disturbances import Disturber
from hmrsim.fault_search.running.actors import GRACE, Actor
from hmrsim.fault_search.running.cast import GONE, Cast

if TYPE_CHECKING:
    from hmrsim.experiments.running.controllers import Controller
    from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

_POLL: Final = 0.002
"""Wall seconds between two looks at controllers in other threads."""


def run_controller(
    host: LoopbackHost,
    controller: Controller,
    disturber: Disturber | None = None,
    name: str = "client",
    on_end: Callable[[str], None] = lambda _ending: None,
) -> tuple[str, str]:
    """Run a controller to its end; return its ending, and the cause if it has not ended by itself.

    Endings are those of `hmrsim.experiments.running.controlling.control`, and `KILLED`. Of a controller that was
    started again the last run counts; one that is gone for good is represented by the second one, if there is one. The
    second one is killed when the first has ended.

    Args:
        host: Serves the world; *disturber* watches it.
        controller: What is run.
        disturber: What disturbs it.
        name: The participant's name.
        on_end: Called with the ending while time stands, before the clients leave.
    """
    return _Controllers(host, controller, disturber or Disturber(), name).run(on_end)


class _Controllers(Cast):
    """The controllers of a run."""

    def __init__(self, host: LoopbackHost, controller: Controller, disturber: Disturber, name: str) -> None:
        self._host = host
        self._controller = controller
        self._name = name
        self._first = Actor(host, controller, name)
        self._others: list[Actor] = []
        super().__init__(host, disturber)

    def run(self, on_end: Callable[[str], None]) -> tuple[str, str]:
        try:
            self._first.play()
            while self._first.killed and self._awaits_restart():
                self._first = Actor(self._host, self._controller, self._name)
                self._first.play()
            ending, cause = self._ending()
        except TimeLimit as limit:
            ending, cause = HUNG, str(limit)
        on_end(ending)
        for each in self._others:
            each.end()
        self._first.close()
        return ending, cause

    @property
    def _own_names(self) -> Sequence[str]:
        return (self._name,)

    def _kill(self, restart_after: float | None) -> None:
        if self._first.killed:
            return
        self._first.kill()
        lockstep = self._lockstep
        if restart_after is None:
            self._gone = True
            lockstep.expect("", math.inf)
        else:
            lockstep.expect(self._name, self._simulator.now + restart_after, self._restarts.set)

    def _add(self) -> None:
        """Start one more controller beside the first; those before it come first in all that they say."""
        before = (self._name, *(each.name for each in self._others))
        lockstep = self._lockstep
        # The run ends with the first one, which may have left lockstep by then.
        lockstep.keep(self._name)
        name = f"{self._name}_{len(before) + 1}"
        actor = Actor(self._host, self._controller, name, lambda: not {*before}.isdisjoint(lockstep.waiting_for))
        self._others.append(actor)
        actor.play_aside(stays=lambda: self._gone)

    def _awaits_restart(self) -> bool:
        """Let time go on until the controller that was killed is to be started again; return whether it is."""
        while not self._restarts.is_set():
            self._host.go_on()
            plays = any(each.plays_aside(_POLL) for each in self._others)
            if self._host.pacing.over:
                # The others are told of the end, and have an ending of their own by then.
                for each in self._others:
                    each.plays_aside(GRACE)
                return False
            if not (plays or self._restarts.is_set()):
                return False
        self._restarts.clear()
        return not self._host.pacing.over

    def _ending(self) -> tuple[str, str]:
        """Return how the run has ended."""
        others = [each.ended for each in self._others if each.ended is not None]
        own = self._first.ended
        if own is None:
            return others[0] if others else GONE
        crash = next((cause for ending, cause in others if ending == CRASHED), None)
        return own if crash is None or own[0] not in {SUCCEEDED, FAILED} else (CRASHED, f"a second controller: {crash}")
