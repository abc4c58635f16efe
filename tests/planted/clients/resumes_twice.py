"""After a failure the robot continues when its fault has ended, and by a timer that is not canceled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from driving import Driver, Handle, listen

from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

ROUND = ("ward_a", "ward_b", "ward_c", "home")
PATIENCE = 20.0


def rounds(client: Client, *, bug: bool = False) -> bool:
    return _Rounds(client, bug=bug).run()


class _Rounds:
    def __init__(self, client: Client, *, bug: bool) -> None:
        self._client, self._bug = client, bug
        self._driver = Driver(client, "wall_e")
        self._repaired = False
        self._timers: list[float] = []
        listen(client, self._note)

    def _note(self, event: dict[str, Any]) -> None:
        self._repaired |= event["kind"] == "fault_ended" and event.get("robot") == self._driver.robot

    def run(self) -> bool:
        leg, failures = 0, 0
        handle: Handle | None = self._driver.start_to(ROUND[0])
        while leg < len(ROUND):
            self._client.sleep(1.0)
            if handle is not None and handle.done:
                if handle.status is GoalStatus.SUCCEEDED:
                    leg, failures = leg + 1, 0
                    handle = self._driver.start_to(ROUND[leg]) if leg < len(ROUND) else None
                else:
                    handle, failures = None, failures + 1
                    self._timers.append(self._client.now + PATIENCE)
                    self._repaired = False
            if failures > 9:
                return False
            if leg < len(ROUND) and self._resumes(idle=handle is None):
                # The leg that failed, as it was noted then.
                handle = self._driver.start_to(ROUND[leg - 1 if self._bug and handle is not None else leg])
        return True

    def _resumes(self, *, idle: bool) -> bool:
        now = self._client.now
        due = any(timer <= now for timer in self._timers)
        self._timers = [timer for timer in self._timers if timer > now]
        if idle and self._repaired:
            self._repaired = False
            if not self._bug:  # the bug: the timer stays
                self._timers.clear()
            return True
        return due and (idle or self._bug)
