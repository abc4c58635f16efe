"""``hmrsim action``: the robots' actions, as in ``ros2 action``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from shlex import quote
from typing import TYPE_CHECKING, Any, get_args

from hmrsim.cli import listing, names, send_goal
from hmrsim.cli.connection import connected
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.goal_examples import example_of
from hmrsim.cli.output import show, show_json, yaml_flow
from hmrsim.interfaces.message import Primitive
from hmrsim_zenoh.wire.options import ENVIRONMENT

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message

_EXAMPLES = f"""\
examples:
  hmrsim action list -t
  hmrsim action info /mocha/pickup
  hmrsim action send-goal /mocha/pickup '{{target_name: coffee}}' --feedback

{ENVIRONMENT}"""

_LIST_EXAMPLES = f"""\
examples:
  hmrsim action list
  hmrsim action list --show-types --connect tcp/10.0.0.7:7447
  hmrsim action list --json | jq -r '.[].name'

{ENVIRONMENT}"""

_INFO_EXAMPLES = f"""\
examples:
  hmrsim action info /mocha/navigate_to_pose
  hmrsim action info mocha/pickup --json

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim action``."""
    parser.description = "List actions and send goals, as with `ros2 action`."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    lister = commands.add_parser(
        "list",
        help="list the actions of all robots",
        description="List the actions of all robots, one a line.",
        epilog=_LIST_EXAMPLES,
    )
    listing.configure(lister, _names)
    info = commands.add_parser(
        "info",
        help="show the goal, result and feedback of an action",
        description="Show the goal, result and feedback of an action.",
        epilog=_INFO_EXAMPLES,
    )
    info.add_argument("name", metavar="NAME", help="/ROBOT/ACTION or an alias")
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(function=_info)
    add_connection_options(info)
    send_goal.configure(
        commands.add_parser("send-goal", aliases=["send_goal"], help="send a goal and follow it to its end")
    )


def _names(_args: argparse.Namespace, info: names.Info) -> Iterator[dict[str, Any]]:
    for one in names.actions(info):
        yield {"name": one.name, "type": one.ros_type, "robot": one.robot, "action": one.action}


def _info(args: argparse.Namespace) -> int:
    with connected(args) as (client, info):
        one = names.find_action(info, args.name)
        target = f"{one.robot}/{one.action}"
        also = [f"/{alias}" for alias, meant in names.aliases(info).items() if meant == target]
        action = one.definition()
        example = None if args.json else example_of(client, action, one.robot)
    if args.json:
        show_json(
            {"name": f"/{target}", "type": action.ros_type, "robot": one.robot, "aliases": also, **_parts(action)}
        )
        return ExitCode.DONE
    show(f"Action: /{target}\nType: {action.ros_type}\nRobot: {one.robot}")
    if also:
        show(f"Aliases: {', '.join(also)}")
    show("Action servers: 1")
    for part, fields in _parts(action).items():
        constants = _constants(getattr(action, part))
        show("\n".join((f"{part.title()}:", *(f"    {field}: {kind}" for field, kind in fields.items()), *constants)))
    if example is not None:
        show(f"Example: hmrsim action send-goal /{target} {quote(yaml_flow(dict(example)))}")
    return ExitCode.DONE


def _parts(action: AnyAction) -> dict[str, dict[str, str]]:
    parts = {"goal": action.goal, "result": action.result, "feedback": action.feedback}
    return {part: _fields(message) for part, message in parts.items()}


def _constants(message: type[Message]) -> Iterator[str]:
    """Yield the lines of a message's constants, as ``ros2 interface show`` has them."""
    return (f"    {name}={value}" for name, value in vars(message).items() if name.isupper())


def _fields(message: type[Message]) -> dict[str, str]:
    return {name: _ros_type(field) for name, field in message.model_fields.items()}


def _ros_type(field: FieldInfo) -> str:
    """Return the ROS type of a field, such as ``geometry_msgs/msg/PoseStamped[]``."""
    primitive = next((mark.name for mark in field.metadata if isinstance(mark, Primitive)), None)
    return primitive or _name_of(field.annotation)


def _name_of(annotation: Any) -> str:
    arguments = get_args(annotation)
    if not arguments:
        return getattr(annotation, "ros_type", "") or annotation.__name__
    primitive = next((mark.name for mark in arguments if isinstance(mark, Primitive)), None)
    return primitive or f"{_name_of(arguments[0])}[]"
