"""``hmrsim topic``: the published topics, as in ``ros2 topic``."""

from __future__ import annotations

import argparse
import queue
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli import listing, topic_hz
from hmrsim.cli.connection import connected, look_for_simulator
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.message_fields import field_of, field_path
from hmrsim.cli.output import show, show_json, yaml_text
from hmrsim.cli.topics import find_topic, topics
from hmrsim.program.signals import on_signals
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.wire.descriptions import plain_values
from hmrsim_zenoh.wire.options import ENVIRONMENT, session_options

if TYPE_CHECKING:
    from hmrsim.cli.names import Info
    from hmrsim.cli.topics import Topic
    from hmrsim_zenoh.client.client import Client

_EXAMPLES: Final = f"""\
examples:
  hmrsim topic list -t
  hmrsim topic echo /mocha/odom --once

{ENVIRONMENT}"""

_LIST_EXAMPLES: Final = f"""\
examples:
  hmrsim topic list
  hmrsim topic list --json | jq -r '.[] | select(.latched).name'

{ENVIRONMENT}"""

_ECHO_EXAMPLES: Final = f"""\
examples:
  hmrsim topic echo /mocha/odom
  hmrsim topic echo /mocha/odom --field pose.pose.position
  hmrsim topic echo /_world/info --once
  hmrsim topic echo /mocha/navigate_to_pose/_action/status --json | jq '.status_list[-1].status'

{ENVIRONMENT}"""

_INFO_EXAMPLES: Final = f"""\
examples:
  hmrsim topic info /mocha/odom
  hmrsim topic info /mocha/odom --json

{ENVIRONMENT}"""

_TYPE_EXAMPLES: Final = f"""\
examples:
  hmrsim topic type /mocha/odom

{ENVIRONMENT}"""

_END: Final = "...\n"
"""What YAML writes after a value that is neither a mapping nor a list."""
_LOOK: Final = 0.5


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim topic``."""
    parser.description = "Show the published topics, as `ros2 topic` does."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    lister = commands.add_parser(
        "list", help="list all topics", description="List all topics, one a line.", epilog=_LIST_EXAMPLES
    )
    lister.add_argument("-a", "--include-hidden-topics", action="store_true", help="list the topics of actions, too")
    listing.configure(lister, _names)
    echo = commands.add_parser(
        "echo",
        help="print the messages of a topic",
        description="Print the messages of a topic until Ctrl-C; the latest one first, where the simulator keeps it.",
        epilog=_ECHO_EXAMPLES,
    )
    echo.add_argument("name", metavar="NAME", help="such as /mocha/odom")
    echo.add_argument(
        "--field", type=field_path, metavar="FIELD", help="print this field alone, such as pose.pose.position"
    )
    echo.add_argument("--once", action="store_true", help="print one message and exit")
    echo.add_argument("--json", action="store_true", help="print one JSON object per line instead of YAML")
    echo.set_defaults(function=_echo)
    add_connection_options(echo)
    info = commands.add_parser(
        "info",
        help="show the type of a topic, and whether it is latched",
        description="Show the type of a topic, and whether its latest message is kept.",
        epilog=_INFO_EXAMPLES,
    )
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(function=_info)
    kind = commands.add_parser(
        "type", help="print the type of a topic", description="Print the type of a topic.", epilog=_TYPE_EXAMPLES
    )
    kind.set_defaults(function=_type)
    for command in (info, kind):
        command.add_argument("name", metavar="NAME", help="such as /mocha/odom")
        add_connection_options(command)
    topic_hz.configure(commands.add_parser("hz", help="measure how often a topic is published"))


def _names(args: argparse.Namespace, info: Info) -> Iterator[dict[str, Any]]:
    for one in topics(info):
        if args.include_hidden_topics or not one.hidden:
            yield {"name": one.name, "type": one.ros_type, "latched": one.latched, "hidden": one.hidden}


def _info(args: argparse.Namespace) -> int:
    with connected(args) as (_, info):
        topic = find_topic(info, args.name)
    if args.json:
        show_json({"name": topic.name, "type": topic.ros_type, "latched": topic.latched, "hidden": topic.hidden})
        return ExitCode.DONE
    show(f"Topic: {topic.name}\nType: {topic.ros_type}\nPublisher count: 1")
    show(f"Latched: {'yes, the latest message is there at once' if topic.latched else 'no'}")
    return ExitCode.DONE


def _type(args: argparse.Namespace) -> int:
    with connected(args) as (_, info):
        show(find_topic(info, args.name).ros_type)
    return ExitCode.DONE


def _echo(args: argparse.Namespace) -> int:
    samples: queue.SimpleQueue[bytes | int] = queue.SimpleQueue()
    with on_signals(samples.put), connected(args) as (client, info):
        topic = find_topic(info, args.name)
        key = topic.key(client.keys)
        with client.subscribe(key, lambda _key, payload: samples.put(payload)):
            for payload in _payloads(client, topic, samples, timeout=session_options(args).timeout):
                _print(payload, args.field or (), as_json=args.json)
                if args.once:
                    break
    return ExitCode.DONE


def _payloads(
    client: Client, topic: Topic, samples: queue.SimpleQueue[bytes | int], *, timeout: float
) -> Iterator[bytes]:
    """Yield the latest message of a topic, if it is latched, then those that are published; ends with a signal.

    Raises:
        SimulatorGone: The simulator has been out of reach for too long.
    """
    latest = None
    if topic.latched:
        # A controller, unlike the simulator, need not be there.
        with suppress(Unreachable):
            latest = client.get(topic.key(client.keys), timeout)
    if latest is not None:
        yield latest
    look = look_for_simulator(client)
    while True:
        try:
            sample = samples.get(timeout=_LOOK)
        except queue.Empty:
            look()
            continue
        if isinstance(sample, int):
            return
        # A message that was published between the subscription and the query comes twice.
        if sample != latest:
            yield sample
        latest = None


def _print(payload: bytes, field: tuple[str | int, ...], *, as_json: bool) -> None:
    data = field_of(plain_values("the message", payload), field)
    if as_json:
        show_json(data)
    else:
        show(f"{yaml_text(data).removesuffix(_END)}---")
