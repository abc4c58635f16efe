"""``hmrsim action``: the robots' actions, as in ``ros2 action``."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from shlex import quote
from typing import TYPE_CHECKING, Any, get_args

from hmrsim.cli import send_goal
from hmrsim.cli.connection import connected
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.options import add_connection_options, add_json
from hmrsim.cli.output import show_result, yaml_flow
from hmrsim.program.command_line import add_commands

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic.fields import FieldInfo

    from hmrsim.actions import AnyAction
    from hmrsim.cli.connection import Info
    from hmrsim.interfaces.message import Message
    from hmrsim.program.command_line import LazyParser


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim action``."""
    parser.description = "List actions and send goals, as with `ros2 action`."
    parser.epilog = """\
examples:
  hmrsim action list -t
  hmrsim action info /mocha/pickup
  hmrsim action send-goal /mocha/pickup '{target_name: coffee}' --feedback"""
    add_commands(
        parser,
        {
            "list": ("list the actions of all robots", _configure_list),
            "info": ("show the goal, result and feedback of an action", _configure_info),
            "send-goal": ("send a goal and follow it to its end", send_goal.configure),
        },
    )


def _configure_list(parser: argparse.ArgumentParser) -> None:
    from hmrsim.cli.names import add_list_arguments

    parser.epilog = """\
examples:
  hmrsim action list
  hmrsim action list --show-types --connect tcp/10.0.0.7:7447
  hmrsim action list --json | jq -r '.[].name'"""
    add_list_arguments(parser, _names)


def _names(_args: argparse.Namespace, info: Info) -> Iterator[dict[str, Any]]:
    from hmrsim.cli.names import actions

    for name in actions(info):
        yield {"name": name.name, "type": name.ros_type, "robot": name.robot, "action": name.action}


def _configure_info(parser: argparse.ArgumentParser) -> None:
    parser.epilog = """\
examples:
  hmrsim action info /mocha/navigate_to_pose
  hmrsim action info mocha/pickup --json"""
    parser.add_argument("name", metavar="NAME", help="/ROBOT/ACTION or an alias")
    add_json(parser)
    parser.set_defaults(function=_info)
    add_connection_options(parser)


def _info(args: argparse.Namespace) -> int:
    from hmrsim.cli.goal_text import example_of
    from hmrsim.cli.names import aliases, find_action

    with connected(args) as (client, info):
        name = find_action(info, args.name)
        target = f"{name.robot}/{name.action}"
        others = [f"/{alias}" for alias, aliased in aliases(info).items() if aliased == target]
        action = name.definition()
        example = None if args.json else example_of(client, action, name.robot)
    facts = {"name": f"/{target}", "type": action.ros_type, "robot": name.robot, "aliases": others, **_parts(action)}
    show_result(facts, _lines(facts, action, example), as_json=args.json)
    return ExitCode.DONE


def _lines(facts: dict[str, Any], action: AnyAction, example: Mapping[str, Any] | None) -> Iterator[str]:
    yield f"Action: {facts['name']}\nType: {facts['type']}\nRobot: {facts['robot']}"
    if facts["aliases"]:
        yield f"Aliases: {', '.join(facts['aliases'])}"
    yield "Action servers: 1"
    for part, fields in _parts(action).items():
        yield f"{part.title()}:"
        yield from (f"    {field}: {kind}" for field, kind in fields.items())
        yield from _constants(getattr(action, part))
    if example is not None:
        yield f"Example: hmrsim action send-goal {facts['name']} {quote(yaml_flow(dict(example)))}"


def _parts(action: AnyAction) -> dict[str, dict[str, str]]:
    parts = {"goal": action.goal, "result": action.result, "feedback": action.feedback}
    return {
        part: {name: _ros_type(field) for name, field in message.model_fields.items()}
        for part, message in parts.items()
    }


def _constants(message: type[Message]) -> Iterator[str]:
    """Return the lines of a message's constants, as in ``ros2 interface show``."""
    return (f"    {name}={value}" for name, value in vars(message).items() if name.isupper())


def _ros_type(field: FieldInfo) -> str:
    """Return the ROS type of a field, such as ``geometry_msgs/msg/PoseStamped[]``."""
    return _primitive(field.metadata) or _name_of(field.annotation)


def _name_of(annotation: Any) -> str:
    arguments = get_args(annotation)
    if not arguments:
        return getattr(annotation, "ros_type", "") or annotation.__name__
    return _primitive(arguments) or f"{_name_of(arguments[0])}[]"


def _primitive(marks: Iterable[object]) -> str | None:
    from hmrsim.interfaces.message import Primitive

    return next((mark.name for mark in marks if isinstance(mark, Primitive)), None)
