"""``hmrsim demo``: a hospital mission, with simulator and controller in separate processes."""

from __future__ import annotations

import argparse
import json
import math
import queue
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.connection import VIEWER
from hmrsim.cli.options import ExitCode, add_json
from hmrsim.cli.output import warn
from hmrsim.errors import HmrsimError
from hmrsim.program.files import check_outputs, check_writable
from hmrsim.program.log_options import add_log_options, log_level
from hmrsim.program.signals import exit_code_of, on_signals
from hmrsim.settings.arguments import add_settings, read_settings
from hmrsim.settings.run import DemoSettings, TraceSettings, WorldSettings
from hmrsim_zenoh.settings import RecordSettings, ViewSettings
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.cli.child import Child
    from hmrsim.cli.demo_screen import Display, Story

_WORLD: Final = "hospital"
_TREE: Final = "bt_controller.examples.hospital:mission"
_ANSWER_SECONDS: Final = 300.0
"""Wall seconds for an answer of the simulator, which a busy machine may take."""
_MISSION_SECONDS: Final = 3600.0
"""Simulated seconds after which the simulator ends the mission, which takes about 200 on a machine that is not busy."""
_LOOK: Final = 0.1
_LAST_EVENTS: Final = 0.3
_PATIENCE: Final = 10.0
"""Wall seconds that a line of one process waits for an earlier line of the other."""
_HOLD: Final = 0.5
"""Wall seconds that a line waits for earlier lines about other robots."""


class _DemoFailed(HmrsimError):
    """A process of the demo failed; the text contains its name and its output."""


class _Interrupted(Exception):
    """A signal ends the demo."""

    def __init__(self, signal: int) -> None:
        super().__init__(signal)
        self.signal = signal


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim demo``."""
    parser.description = (
        "Run a mission of a fleet in a hospital: a simulator and a controller with behavior trees, two processes\n"
        "that communicate over Zenoh. Prints events as they happen, and a summary at the end."
    )
    parser.epilog = """\
examples:
  hmrsim demo
  hmrsim demo --real-time-factor 2 --seed 3
  hmrsim demo --real-time-factor 1 --view
  hmrsim demo --set robots.*.base.speed=0.5
  hmrsim demo --clock lockstep --trace run.jsonl && hmrsim replay run.jsonl
  hmrsim demo --clock lockstep --record demo.mcap && hmrsim view demo.mcap
  hmrsim demo --log-level info 2>processes.log
  hmrsim demo --json | tail -n 1 | jq '.robots.eve.distance'"""
    add_settings(parser, DemoSettings, only=("seed", "clock", "real_time_factor"))
    add_settings(parser, TraceSettings)
    add_settings(parser, RecordSettings)
    add_settings(parser, WorldSettings, only=("overlay", "set"))
    add_settings(parser, ViewSettings)
    add_settings(parser, SessionOptions, only=("secure",))
    add_json(parser, "print each event, and the summary at the end, as one JSON object per line")
    add_log_options(parser)
    parser.set_defaults(function=_demo)


def _demo(args: argparse.Namespace) -> int:
    from hmrsim.cli.demo_screen import JsonLines, Screen
    from hmrsim.cli.event_log import LogLines

    session = read_settings(args, SessionOptions)
    arguments = _run_arguments(args, session)
    screen = JsonLines() if args.json else Screen(sys.stdout)
    demo = _Demo(screen, arguments, ["--log-level", args.log_level, *_security(session)], session.secure)
    log = LogLines(screen.log if sys.stderr.isatty() else None, log_level(args))
    try:
        with log, on_signals(lambda number: demo.news.put(_Interrupted(number))):
            return demo.run()
    except _Interrupted as interruption:
        warn("interrupted; the simulator and the controller have ended")
        return exit_code_of(interruption.signal)


def _run_arguments(args: argparse.Namespace, session: SessionOptions) -> list[str]:
    """Check the options, and return the command line of the simulator."""
    from hmrsim.cli.view import check_page
    from hmrsim.world.files import find
    from hmrsim.world.overlays.overlay import overlays_of
    from hmrsim.world_checks import load_world

    settings, changes = read_settings(args, DemoSettings), read_settings(args, WorldSettings)
    trace, record = read_settings(args, TraceSettings).trace, read_settings(args, RecordSettings).record
    view = read_settings(args, ViewSettings).view
    check_page(view, session)
    check_outputs([("--trace", trace), ("--record", record)], [find(_WORLD)] if trace or record else ())
    if trace is not None:
        check_writable("--trace", trace)
    if overlays := overlays_of(changes.overlay, changes.set):
        load_world(_WORLD, overlays=overlays)
    arguments = ["run", _WORLD, "--listen", f"{'tls' if session.secure else 'tcp'}/127.0.0.1:0", "--json"]
    arguments += ["--feedback-rate", "2", "--duration", str(_MISSION_SECONDS), *_security(session)]
    arguments += ["--clock", settings.clock, "--real-time-factor", str(settings.real_time_factor)]
    arguments += ["--log-level", args.log_level]
    for option, values in (("--overlay", changes.overlay), ("--set", changes.set)):
        arguments += [f"{option}={value}" for value in values]
    for option, value in (("--seed", settings.seed), ("--trace", trace), ("--record", record), ("--view", view)):
        arguments += [] if value is None else [option, str(value)]
    return arguments


def _security(session: SessionOptions) -> list[str]:
    return ["--secure", str(session.secure)] if session.secure else []


class _Demo:
    """One run of the demo."""

    def __init__(
        self, screen: Display, run_arguments: Sequence[str], controller_options: Sequence[str], secure: Path | None
    ) -> None:
        from hmrsim.cli.demo_screen import CausalOrder

        self.news: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._screen = screen
        self._run_arguments, self._controller_options = run_arguments, controller_options
        self._secure = secure
        self._order = CausalOrder(_PATIENCE, _HOLD)

    def run(self) -> int:
        """Start the processes, follow the mission to its end, and stop the processes."""
        from hmrsim.cli.child import Child
        from hmrsim.cli.demo_screen import Story
        from hmrsim_zenoh.client.client import Client

        began = time.monotonic()
        with ExitStack() as stack:
            simulator = stack.enter_context(Child("simulator", "hmrsim.cli:main", self._run_arguments, self._ready))
            ready = self._await_ready(simulator)
            options = SessionOptions(connect=(ready["endpoints"][0],), secure=self._secure, default_role=VIEWER)
            client = stack.enter_context(Client(options))
            client.wait_for_simulator(_ANSWER_SECONDS)
            info = client.info(_ANSWER_SECONDS)
            story = Story({robot["name"]: robot["type"] for robot in info["robots"]})
            client.subscribe(client.keys.world("events"), lambda _key, payload: self.news.put(payload))
            arguments = ["run", _TREE, "--robot", *story.robots, "--json", "--connect", *options.connect]
            arguments += self._controller_options
            controller = stack.enter_context(
                Child("controller", "bt_controller.cli:main", arguments, lambda line: self.news.put((line,)))
            )
            self._screen.note(f"{_WORLD}: {len(story.robots)} robots at {options.connect[0]}; the mission begins")
            if "view" in ready:
                self._screen.note(f"the live picture is at {ready['view']}")
            with self._screen.opened(story):
                self._follow(story)
            code = controller.code(_ANSWER_SECONDS)
        units = info["world"].get("units", "m")
        self._screen.summary(story, time.monotonic() - began, units, succeeded=code == 0)
        for child in (simulator, controller) if code else ():
            if failure := child.code(_LOOK):
                self._screen.note(f"the {child.name} ended with {failure}; it says:\n{child.errors}")
        if "view" not in ready and code == 0:
            self._screen.hint("`hmrsim demo --view` shows the mission in the browser")
        return ExitCode.DONE if code == 0 else ExitCode.FAILED

    def _ready(self, line: str | None) -> None:
        self.news.put({} if line is None else json.loads(line))

    def _await_ready(self, simulator: Child) -> dict[str, Any]:
        # There is no time limit, since the simulator either reports that it is ready or ends.
        ready = self._next(None)
        if not ready:
            simulator.code(_ANSWER_SECONDS)
            raise _DemoFailed(f"the simulator does not start; it says:\n{simulator.errors}")
        return dict(ready)

    def _follow(self, story: Story) -> None:
        """Show the events until the controller has ended."""
        while True:
            item = self._next(_LOOK)
            self._screen.refresh()
            if item == (None,):
                # The last events may still be on their way.
                while (item := self._next(_LAST_EVENTS)) is not None:
                    self._process(story, item)
                self._show(math.inf)
                return
            self._process(story, item)
            self._show(time.monotonic())

    def _process(self, story: Story, item: Any) -> None:
        from hmrsim import events
        from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time

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
            self._order.add(line, time.monotonic())

    def _show(self, now: float) -> None:
        for line in self._order.ready(now):
            self._screen.show(line)

    def _next(self, timeout: float | None) -> Any:
        """Return the next message; None if none arrives within *timeout* wall seconds."""
        try:
            item = self.news.get(timeout=timeout)
        except queue.Empty:
            return None
        if isinstance(item, _Interrupted):
            raise item
        return item
