"""What ``hmrsim demo`` does: it starts a simulator and a controller, and tells what they say."""

from __future__ import annotations

import argparse
import json
import math
import queue
import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Final

from hmrsim import events
from hmrsim.cli.children import Child
from hmrsim.cli.connection import VIEWER
from hmrsim.cli.demo_screen import JsonLines, Screen
from hmrsim.cli.demo_story import Story
from hmrsim.cli.demo_turns import CausalOrder
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import warn
from hmrsim.cli.run_log import LogLines
from hmrsim.cli.tracing import check_writable
from hmrsim.cli.view_options import check_page, check_port
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time
from hmrsim.program.log_options import log_level
from hmrsim.program.outputs import check_outputs
from hmrsim.program.signals import exit_code_of, on_signals
from hmrsim.settings.arguments import read_settings
from hmrsim.settings.run import DemoSettings, TraceSettings, WorldSettings
from hmrsim.world.files import find
from hmrsim.world.overlays.overlay import overlays_of
from hmrsim.world_checks import load_world
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.settings import RecordSettings, ViewSettings
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.cli.demo_screen import Audience


_WORLD: Final = "hospital"
_TREE: Final = "bt_controller.examples.hospital:mission"
_ANSWER_SECONDS: Final = 300.0
"""Wall seconds for an answer of the simulator, which a busy machine may take."""
_MISSION_SECONDS: Final = 600.0
"""Simulated seconds after which the simulator ends the mission; it takes about 200."""
_LOOK: Final = 0.1
_LAST_EVENTS: Final = 0.3
_PATIENCE: Final = 2.0
"""Wall seconds that a line of one process waits for an earlier line of the other."""


class DemoFailed(HmrsimError):
    """A process of the demo failed; the text names it and has its output."""


class _Interrupted(Exception):
    """The user or the system has asked the demo to end."""

    def __init__(self, signal: int) -> None:
        super().__init__(signal)
        self.signal = signal


def demo(args: argparse.Namespace) -> int:
    """Run the demo to its end; return the exit code."""
    settings = read_settings(args, DemoSettings)
    trace, view = read_settings(args, TraceSettings).trace, read_settings(args, ViewSettings).view
    session = read_settings(args, SessionOptions)
    check_port(view)
    check_page(view, session)
    record = read_settings(args, RecordSettings).record
    check_outputs([("--trace", trace), ("--record", record)], [find(_WORLD)] if trace or record else ())
    check_writable(trace, ())
    screen = JsonLines() if args.json else Screen(sys.stdout)
    changes = read_settings(args, WorldSettings)
    if overlays := overlays_of(changes.overlay, changes.set):
        load_world(_WORLD, overlays=overlays)
    demo = _Demo(
        settings,
        screen,
        trace=trace,
        record=record,
        view=view,
        secure=session.secure,
        log_level=args.log_level,
        changes=changes,
    )
    log = LogLines(screen.log if sys.stderr.isatty() else None, log_level(args))
    try:
        with log, on_signals(lambda number: demo.news.put(_Interrupted(number))):
            return demo.run()
    except _Interrupted as interruption:
        warn("interrupted; the simulator and the controller have ended")
        return exit_code_of(interruption.signal)


class _Demo:
    """One run of the demo."""

    def __init__(
        self,
        settings: DemoSettings,
        screen: Audience,
        *,
        trace: Path | None,
        record: Path | None,
        view: int | None,
        secure: Path | None,
        log_level: str,
        changes: WorldSettings,
    ) -> None:
        self.news: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._settings = settings
        self._trace, self._record, self._view, self._secure = trace, record, view, secure
        self._log_level = log_level
        self._screen, self._changes = screen, changes
        self._turns = CausalOrder(_PATIENCE)

    def run(self) -> int:
        """Start everything, follow the mission to its end, and end everything.

        Raises:
            DemoFailed: The simulator does not start.
            SimulatorNotFound: The simulator can't be reached.
        """
        began = time.monotonic()
        with ExitStack() as stack:
            simulator = stack.enter_context(Child("simulator", "hmrsim.cli:main", self._run_arguments(), self._ready))
            ready = self._await_ready(simulator)
            options = SessionOptions(connect=(ready["endpoints"][0],), secure=self._secure, default_role=VIEWER)
            client = stack.enter_context(Client(options))
            client.wait_for_simulator(_ANSWER_SECONDS)
            info = client.info(_ANSWER_SECONDS)
            story = Story({robot["name"]: robot["type"] for robot in info["robots"]})
            client.subscribe(client.keys.world("events"), lambda _key, payload: self.news.put(payload))
            arguments = ["run", _TREE, "--robot", *story.robots, "--json", "--connect", *options.connect]
            arguments += ["--log-level", self._log_level, *self._security()]
            controller = stack.enter_context(
                Child("controller", "bt_controller.cli:main", arguments, lambda line: self.news.put((line,)))
            )
            self._screen.say(f"{_WORLD}: {len(story.robots)} robots at {options.connect[0]}; the mission begins")
            if "view" in ready:
                self._screen.say(f"the live picture is at {ready['view']}")
            with self._screen.opened(story):
                self._follow(story)
            code = controller.code(_ANSWER_SECONDS)
        units = info["world"].get("units", "m")
        self._screen.summary(story, time.monotonic() - began, units, succeeded=code == 0)
        for child in (simulator, controller) if code else ():
            if failure := child.code(_LOOK):
                self._screen.say(f"the {child.name} ended with {failure}; it says:\n{child.said}")
        return ExitCode.DONE if code == 0 else ExitCode.FAILED

    def _run_arguments(self) -> list[str]:
        listen = f"{'tls' if self._secure else 'tcp'}/127.0.0.1:0"
        arguments = ["run", _WORLD, "--listen", listen, "--json", "--feedback-rate", "2", *self._security()]
        arguments += ["--duration", str(_MISSION_SECONDS)]
        settings = self._settings
        arguments += ["--clock", settings.clock, "--real-time-factor", str(settings.real_time_factor)]
        arguments += ["--log-level", self._log_level]
        for option, values in (("--overlay", self._changes.overlay), ("--set", self._changes.set)):
            arguments += [f"{option}={value}" for value in values]
        outputs = (("--trace", self._trace), ("--record", self._record))
        for option, value in (("--seed", settings.seed), *outputs, ("--view", self._view)):
            arguments += [] if value is None else [option, str(value)]
        return arguments

    def _security(self) -> list[str]:
        return ["--secure", str(self._secure)] if self._secure else []

    def _ready(self, line: str | None) -> None:
        self.news.put({} if line is None else json.loads(line))

    def _await_ready(self, simulator: Child) -> dict[str, Any]:
        # However long that takes: it says so when it is ready, or has ended.
        ready = self._next(None)
        if not ready:
            simulator.code(_ANSWER_SECONDS)
            raise DemoFailed(f"the simulator does not start; it says:\n{simulator.said}")
        return dict(ready)

    def _follow(self, story: Story) -> None:
        """Show the events until the controller has ended."""
        while True:
            item = self._next(_LOOK)
            self._screen.refresh()
            if item == (None,):
                # The last events may not have arrived yet.
                while (item := self._next(_LAST_EVENTS)) is not None:
                    self._hear(story, item)
                self._tell(math.inf)
                return
            self._hear(story, item)
            self._tell(time.monotonic())

    def _hear(self, story: Story, item: Any) -> None:
        """Take an event of the world, or a tree of the controller."""
        match item:
            case bytes():
                event = json.loads(item)
                at = Time.model_validate(event["stamp"]).to_nanoseconds() / NANOSECONDS
                lines = story.on_event(at, events.from_json(event))
            case (str() as tree,):
                lines = story.ticked(json.loads(tree))
            case _:
                return
        for line in lines:
            self._turns.add(line, time.monotonic())

    def _tell(self, now: float) -> None:
        for line in self._turns.ready(now):
            self._screen.tell(line)

    def _next(self, timeout: float | None) -> Any:
        """Return the next message; None when there is none within *timeout* wall seconds, if there is such a limit.

        Raises:
            _Interrupted: A signal arrived.
        """
        try:
            item = self.news.get(timeout=timeout)
        except queue.Empty:
            return None
        if isinstance(item, _Interrupted):
            raise item
        return item
