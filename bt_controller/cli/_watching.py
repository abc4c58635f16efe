"""The outputs of ``bt-controller`` for trees: the terminal, files and the network."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from bt_controller.watching.display import JsonDisplay, PlainDisplay, Transitions
from bt_controller.watching.publishing import Publisher
from bt_controller.watching.renders import check_graphviz, dot, svg
from hmrsim.program.files import STDOUT, TextOutput, check_outputs, check_writable, write_text

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from bt_controller.coverage import TreeCoverage
    from bt_controller.loading.trees import Plan
    from bt_controller.running.clocks import Clock
    from bt_controller.running.mission import Mission
    from bt_controller.running.snapshot import Node
    from bt_controller.watching.display import Watcher
    from hmrsim_zenoh.client.client import Client


def check_files(args: argparse.Namespace, plan: Plan) -> None:
    """Check that no output file is also an input file or another output file.

    Raises:
        OutputError: Two options name the same file.
    """
    outputs = [(f"--{name}", getattr(args, name, None)) for name in ("transitions", "dot", "svg", "coverage")]
    check_outputs(outputs, [*plan.files, getattr(args, "zenoh_config", None)])


def check_pictures(args: argparse.Namespace) -> None:
    """Check that pictures can be drawn, before the trees run.

    Raises:
        OutputError: A file can't be written.
        BadOptions: Graphviz is missing.
    """
    for option, name in (("--dot", args.dot), ("--svg", args.svg)):
        if name and name != STDOUT:
            check_writable(option, Path(name))
    if args.svg:
        check_graphviz()


def draw(args: argparse.Namespace, trees: Mapping[str, Sequence[Node]], *, statuses: bool) -> None:
    """Write the pictures that the command line requests.

    Raises:
        BadOptions: Graphviz is missing.
        OutputError: A file can't be opened.
        WriteError: The disk is full.
    """
    if args.dot or args.svg:
        graph = dot(trees, statuses=statuses)
        if args.dot == STDOUT:
            sys.stdout.write(graph)
        elif args.dot:
            write_text("--dot", Path(args.dot), graph)
        if args.svg:
            write_text("--svg", Path(args.svg), svg(graph))


def display(args: argparse.Namespace) -> AbstractContextManager[Watcher | None]:
    """Return the display of trees on stdout, if any."""
    if args.quiet:
        return nullcontext()

    if args.json:
        return nullcontext(JsonDisplay(sys.stdout))
    if not sys.stdout.isatty():
        return nullcontext(PlainDisplay(sys.stdout))
    # Loads rich, which takes 60 ms and is needed for terminals only.
    from bt_controller.watching.live_display import live_display

    return live_display()


@contextmanager
def covering(args: argparse.Namespace) -> Iterator[TreeCoverage | None]:
    """Yield the coverage to count in, if the options request it; it is written in the end, even after an error.

    Raises:
        CoverageError: The file exists, but is not coverage.
        OutputError: The file can't be written.
        WriteError: The disk is full.
    """
    if args.coverage is None:
        yield None
        return
    # They take 10 ms to load.
    from bt_controller.coverage import TreeCoverage
    from bt_controller.coverage.files import check_mergeable, merge_into

    check_mergeable("--coverage", args.coverage)
    coverage = TreeCoverage()
    try:
        yield coverage
    finally:
        if coverage.trees:
            merge_into("--coverage", args.coverage, coverage)


@contextmanager
def watching(
    args: argparse.Namespace, client: Client, missions: Sequence[Mission], clock: Clock, shown: Watcher | None
) -> Iterator[Callable[[Mission, float | None], None]]:
    """Open the outputs of ticks; yield the function to call after each tick.

    Raises:
        OutputError: A file can't be opened.
        WriteError: The disk is full; also while a tick is written.
        BadOptions: A port for Groot2 is taken, or its packages are missing.
    """
    with ExitStack() as ending:
        watchers: list[Watcher] = [ending.enter_context(Publisher(client.session, client.keys, missions))]
        if shown is not None:
            watchers.insert(0, shown)
        if args.transitions or Transitions.wanted():
            file = TextOutput("--transitions", Path(args.transitions)) if args.transitions else None
            out = file and ending.enter_context(file)
            transitions = Transitions(out, missions)
            ending.callback(lambda: transitions.flush(clock.now))
            watchers.append(transitions)

        if (port := getattr(args, "groot2", None)) is not None:
            # Loads ZeroMQ.
            from bt_controller.watching.groot2 import Groot2Publishers

            publishers = ending.enter_context(Groot2Publishers(missions, port))
            watchers.append(publishers)
            for robot, served in publishers.ports.items():
                print(f"bt-controller: Groot2 can show the tree of {robot} at port {served}", file=sys.stderr)

        def ticked(mission: Mission, now: float | None) -> None:
            for watcher in watchers:
                watcher.ticked(mission, now)

        yield ticked
