"""Ctrl-C in a script that takes part in lockstep, at any function that the client enters.

CPython runs signal handlers when a function is entered, among others, so that each of these moments is a real one.
"""

from __future__ import annotations

import json
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from tests.patience import PATIENCE
from tests.served_world import served_world

WAIT = registry()["wait"]


class Interrupt:
    """Raises KeyboardInterrupt when the client's code enters its *at*-th function; a function for sys.settrace."""

    def __init__(self, at: int) -> None:
        self.left = at
        self.where = ""

    def __call__(self, frame, _event, _argument) -> None:
        if "/hmrsim_zenoh/client/" in frame.f_code.co_filename and not self.where:
            self.left -= 1
            if not self.left:
                self.where = f"{frame.f_code.co_qualname} in {frame.f_code.co_filename}"
                raise KeyboardInterrupt


@contextmanager
def traced(function) -> Iterator[None]:
    """Call a function at each entry into another one, and restore the tracing of a coverage measurement."""
    before = sys.gettrace()
    sys.settrace(function)
    try:
        yield
    finally:
        sys.settrace(before)


@contextmanager
def passing_time(options) -> Iterator[None]:
    """Let time pass second by second through another participant."""
    over = threading.Event()
    with Client(options, name="nurse") as nurse:
        nurse.sleep(1.0)

        def go_on():
            while not over.is_set():
                nurse.sleep(1.0)

        thread = threading.Thread(target=go_on)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()


def interrupted_script(options, at) -> Interrupt:
    """Interrupt a script before or while it waits for a goal that it then cancels; return where it was."""
    interrupt, goal = Interrupt(at), None
    # Of two clients of one name, the token of the first may be reported as gone after that of the second has come.
    with Client(options, name=f"script_{at}") as client:
        wait = client.action_client("wall_e", WAIT)
        # It takes part before it sends something.
        assert client.now >= 0.0
        try:
            with traced(interrupt):
                goal = wait.send_goal(Wait.Goal(time=Duration(sec=3)))
                goal.result(PATIENCE)
        except KeyboardInterrupt:
            if goal is not None:
                goal.cancel()
                goal.result(PATIENCE)
    return interrupt


def test_no_interrupt_loses_a_goal():
    """Wherever it is interrupted, the script can cancel its goal and learns of its end."""
    with served_world(clock="lockstep") as options, passing_time(options), Client(options, clock="realtime") as watcher:
        for at in count(1):
            interrupt = interrupted_script(options, at)
            statuses = json.loads(watcher.get("hmrsim/wall_e/wait/_action/status"))["status_list"]
            assert all(GoalStatus(each["status"]).terminal for each in statuses), interrupt.where
            if not interrupt.where:
                break

    assert at > 50
