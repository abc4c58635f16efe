"""``hmrsim topic``: the published topics, as in ``ros2 topic``."""

from __future__ import annotations

import argparse
import queue
import re
import statistics
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.connection import connected, received
from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, add_connection_options, add_json, count
from hmrsim.cli.output import show, show_json, show_result, warn, yaml_text
from hmrsim.diagnostics import instead
from hmrsim.program.command_line import add_commands
from hmrsim.program.signals import on_signals
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from hmrsim.cli.names import Topic
    from hmrsim.program.command_line import CommandParser
    from hmrsim_zenoh.client.client import Client

_END: Final = "...\n"
"""The end that YAML writes after a value that is neither a mapping nor a list."""
_PERIOD: Final = 1.0
"""Wall seconds between two lines of ``hz``."""

_STEP: Final = re.compile(r"(?P<name>\w+)|\[(?P<index>-?\d+)\]")
_FIELD: Final = re.compile(r"\w+(\[-?\d+\])*(\.\w+(\[-?\d+\])*)*")


def configure(parser: CommandParser) -> None:
    """Add the commands of ``hmrsim topic``."""
    parser.description = "Show the published topics, as `ros2 topic` does."
    parser.epilog = """\
examples:
  hmrsim topic list -t
  hmrsim topic echo /mocha/odom --once"""
    add_commands(
        parser,
        {
            "list": ("list all topics", _configure_list),
            "echo": ("print the messages of a topic", _configure_echo),
            "info": ("show the type of a topic, and whether it is latched", _configure_info),
            "type": ("print the type of a topic", _configure_type),
            "hz": ("measure how often a topic is published", _configure_hz),
        },
    )


def _configure_list(parser: argparse.ArgumentParser) -> None:
    from hmrsim.cli.names import add_list_arguments, topics

    parser.epilog = """\
examples:
  hmrsim topic list
  hmrsim topic list --json | jq -r '.[] | select(.latched).name'"""
    add_list_arguments(parser, topics, of_actions="topics")


def _configure_echo(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Print the messages of a topic until Ctrl-C, starting with the latest one if the topic is latched."
    )
    parser.epilog = """\
examples:
  hmrsim topic echo /mocha/odom
  hmrsim topic echo /mocha/odom --field pose.pose.position
  hmrsim topic echo /_world/info --once
  hmrsim topic echo /mocha/navigate_to_pose/_action/status --json | jq '.status_list[-1].status'"""
    _add_name(parser)
    parser.add_argument(
        "--field", type=field_path, metavar="FIELD", help="print only this field, such as pose.pose.position"
    )
    parser.add_argument("--once", action="store_true", help="print one message and exit")
    add_json(parser, "print one JSON object per line instead of YAML")
    parser.set_defaults(function=_echo)
    add_connection_options(parser)


def _configure_info(parser: argparse.ArgumentParser) -> None:
    parser.description = "Show the type of a topic, and whether its latest message is kept."
    parser.epilog = """\
examples:
  hmrsim topic info /mocha/odom
  hmrsim topic info /mocha/odom --json"""
    _add_name(parser)
    add_json(parser)
    parser.set_defaults(function=_info)
    add_connection_options(parser)


def _configure_type(parser: argparse.ArgumentParser) -> None:
    parser.epilog = """\
examples:
  hmrsim topic type /mocha/odom"""
    _add_name(parser)
    parser.set_defaults(function=_type)
    add_connection_options(parser)


def _configure_hz(parser: argparse.ArgumentParser) -> None:
    parser.description = "Measure how often a topic is published by the wall clock, each second until Ctrl-C."
    parser.epilog = """\
examples:
  hmrsim topic hz /mocha/odom
  hmrsim topic hz /_world/clock --window 100 --json"""
    _add_name(parser)
    parser.add_argument(
        "--window", type=count, default=10_000, metavar="N", help="the latest N messages (default: %(default)s)"
    )
    add_json(parser, "print one JSON object per line")
    parser.set_defaults(function=_hz)
    add_connection_options(parser)


def _add_name(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="such as /mocha/odom")


def _info(args: argparse.Namespace) -> int:
    topic = _find(args)
    lines = (
        f"Topic: {topic.name}\nType: {topic.ros_type}\nPublisher count: 1",
        f"Latched: {'yes, the latest message is there at once' if topic.latched else 'no'}",
    )
    show_result(topic.entry, lines, as_json=args.json)
    return ExitCode.DONE


def _type(args: argparse.Namespace) -> int:
    show(_find(args).ros_type)
    return ExitCode.DONE


def _find(args: argparse.Namespace) -> Topic:
    from hmrsim.cli.names import find_topic

    with connected(args) as (_, info):
        return find_topic(info, args.name)


def _echo(args: argparse.Namespace) -> int:
    from hmrsim.cli.names import find_topic

    samples: queue.SimpleQueue[bytes | int] = queue.SimpleQueue()
    with on_signals(samples.put), connected(args) as (client, info):
        topic = find_topic(info, args.name)
        with client.subscribe(topic.key(client.keys), lambda _key, payload: samples.put(payload)):
            for payload in _payloads(client, topic, samples, timeout=session_options(args).timeout):
                _print(payload, args.field or (), as_json=args.json)
                if args.once:
                    break
    return ExitCode.DONE


def _payloads(
    client: Client, topic: Topic, samples: queue.SimpleQueue[bytes | int], *, timeout: float
) -> Iterator[bytes]:
    """Yield the messages of a topic as they are published, until a signal arrives; a latched one first."""
    latest = None
    if topic.latched:
        # The publisher may be a controller that is not running.
        with suppress(Unreachable):
            latest = client.get(topic.key(client.keys), timeout)
    if latest is not None:
        yield latest
    for sample in received(client, samples):
        if isinstance(sample, int):
            return
        if sample is not None:
            # A message published between the subscription and the query arrives twice.
            if sample != latest:
                yield sample
            latest = None


def _print(payload: bytes, field: tuple[str | int, ...], *, as_json: bool) -> None:
    from hmrsim_zenoh.wire.descriptions import plain_values

    data = field_of(plain_values("the message", payload), field)
    if as_json:
        show_json(data)
    else:
        show(f"{yaml_text(data).removesuffix(_END)}---")


def _hz(args: argparse.Namespace) -> int:
    from hmrsim.cli.names import find_topic

    signals: queue.SimpleQueue[int] = queue.SimpleQueue()
    arrivals: deque[float] = deque(maxlen=args.window + 1)
    with on_signals(signals.put), connected(args) as (client, info):
        topic = find_topic(info, args.name)
        with client.subscribe(topic.key(client.keys), lambda _key, _payload: arrivals.append(time.monotonic())):
            last = 0.0
            for signal in received(client, signals, _PERIOD):
                if signal is not None:
                    break
                last = _show_rate(list(arrivals), last, as_json=args.json)
    return ExitCode.DONE


def _show_rate(arrivals: Sequence[float], last: float, *, as_json: bool) -> float:
    """Print the rate if a message has arrived since *last*; return when the latest one arrived."""
    if len(arrivals) < 2 or arrivals[-1] == last:  # noqa: PLR2004 - a rate needs two
        warn("no new messages")
        return last
    gaps = [after - before for before, after in pairwise(arrivals)]
    rate = {
        "average_rate": 1.0 / statistics.fmean(gaps),
        "min": min(gaps),
        "max": max(gaps),
        "std_dev": statistics.pstdev(gaps),
        "window": len(gaps),
    }
    text = (
        f"average rate: {rate['average_rate']:.3f}\n\tmin: {rate['min']:.3f}s max: {rate['max']:.3f}s "
        f"std dev: {rate['std_dev']:.5f}s window: {rate['window']}"
    )
    show_result(rate, text, as_json=as_json)
    return arrivals[-1]


def field_path(text: str) -> tuple[str | int, ...]:
    """Return the steps to a field: names of fields, and indices of lists.

    Raises:
        WrongUse: The text is not of a form such as ``pose.pose.position`` or ``status_list[-1].status``.
    """
    if not _FIELD.fullmatch(text):
        raise WrongUse(f"--field: {text!r} is not a field; expected one such as pose.pose.position or poses[0].header")
    return tuple(int(step["index"]) if step["index"] is not None else step["name"] for step in _STEP.finditer(text))


def field_of(message: Any, path: tuple[str | int, ...]) -> Any:
    """Return the value of a field in the plain values of a message.

    Raises:
        UnknownName: The message has no such field.
    """
    value, passed = message, ""
    for step in path:
        if isinstance(step, int):
            if not isinstance(value, list):
                raise UnknownName(f"field {passed!r} is not a list")
            if not -len(value) <= step < len(value):
                raise UnknownName(f"field {passed!r} has {len(value)} entries, and none at [{step}]")
            value, passed = value[step], f"{passed}[{step}]"
            continue
        if not isinstance(value, dict) or step not in value:
            names = list(value) if isinstance(value, dict) else []
            where = f"field {passed!r} has" if passed else "the message has"
            raise UnknownName(f"{where} no field {step!r}{instead(step, names)}")
        value, passed = value[step], f"{passed}.{step}".removeprefix(".")
    return value
