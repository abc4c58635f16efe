"""``hmrsim action``: the robots' actions, as in ``ros2 action``; Ctrl-C cancels a goal that was sent."""

from __future__ import annotations

import argparse
import queue
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from shlex import quote
from typing import TYPE_CHECKING, Any, Final, get_args

from hmrsim.cli.connection import OPERATOR, connected, in_run, value_of
from hmrsim.cli.options import ExitCode, Refused, UnknownName, WrongUse, add_connection_options, add_json
from hmrsim.cli.output import show, show_json, show_result, warn, yaml_flow, yaml_text
from hmrsim.diagnostics import shown
from hmrsim.errors import HmrsimError
from hmrsim.program.command_line import add_commands
from hmrsim.program.signals import exit_code_of, on_signals
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.time import LOCKSTEP
from hmrsim_zenoh.errors import Denied, GoalRejectedError, RequestError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic.fields import FieldInfo

    from hmrsim.actions import AnyAction
    from hmrsim.cli.names import ActionName
    from hmrsim.interfaces.message import Message
    from hmrsim.program.command_line import CommandParser
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.goal_handle import GoalHandle


_EXAMPLES: Final = """\
examples:
  hmrsim action send-goal /mocha/navigate_to_pose '{pose: counter}' --feedback
  hmrsim action send-goal /mocha/navigate_to_pose '{pose: [2, 3]}'
  hmrsim action send-goal mocha/pickup moveit_msgs/action/Pickup '{target_name: coffee}'
  hmrsim action send-goal /mocha/wait '{time: {sec: 3}}' --json
  hmrsim action send-goal /mocha/undock_robot"""

_LOOK: Final = 1.0
_DRAIN_TIMEOUT: Final = 0.05
_CANCEL_WAIT: Final = 2.0


def _configure_send_goal(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Send a goal and follow it to its end; Ctrl-C cancels it. Empty fields are omitted; --json shows all."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("name", metavar="NAME", help="/ROBOT/ACTION or an alias")
    parser.add_argument("type", metavar="TYPE", nargs="?", help="the action's ROS type, as for `ros2 action send_goal`")
    parser.add_argument(
        "goal",
        metavar="GOAL",
        nargs="?",
        help="the goal as YAML; omitted fields have their ROS defaults; a pose may be a place, [x, y] or [x, y, yaw]",
    )
    parser.add_argument(
        "-f", "--feedback", action="store_true", help="show feedback, too: one line per sample on a terminal, else YAML"
    )
    parser.add_argument("-v", "--verbose", action="store_true", help="show feedback as YAML on a terminal, too")
    add_json(parser, "print the outcome as one JSON object, after one line of JSON per feedback")
    parser.add_argument("--goal-id", metavar="HEX", help="32 hex digits, hyphens optional; generated if not given")
    parser.set_defaults(function=_send_goal)
    add_connection_options(parser)


def _send_goal(args: argparse.Namespace) -> int:
    from hmrsim.cli.goal_text import read_goal, read_yaml, type_and_text
    from hmrsim.cli.names import find_action

    ros_type, text = type_and_text(args.type, args.goal, "an action", "goal")
    data = None if text is None else read_yaml(text)
    goal_id = _goal_id(args.goal_id)
    participant = re.sub(r"\W+", "_", args.name).strip("_")
    with connected(args, OPERATOR, name=participant) as (client, info):
        name = find_action(info, args.name)
        action = name.definition()
        if ros_type is not None and ros_type != action.ros_type:
            raise WrongUse(f"{name.name} is a {action.ros_type}, not a {ros_type}")
        if not isinstance(data, dict):
            data = _empty(client, name, text)
        goal = read_goal(_with_poses(client, data, action), action.goal)
        brief = sys.stdout.isatty() and not args.verbose
        report = _Report(as_json=args.json, feedback=args.feedback or args.verbose, brief=brief)
        if info.get("clock") == LOCKSTEP:
            if in_run():
                return _send_in_lockstep(client, name, goal, goal_id=goal_id, report=report)
            _check_that_time_moves(client)
        return _follow(client, name, goal, goal_id=goal_id, report=report)


def _with_poses(client: Client, data: object, action: AnyAction) -> object:
    """Return the plain values of a goal, with names of places and lists of coordinates replaced by poses."""
    from hmrsim_zenoh.client.places import with_poses

    try:
        return with_poses(data, action.goal, client.places.pose)
    except ValueError as error:
        raise UnknownName(str(error)) from None


def _empty(client: Client, name: ActionName, text: str | None) -> dict[str, Any]:
    """Return an empty goal for an action that needs no fields, or raise an error about the given *text*."""
    from hmrsim.cli.goal_text import example_of

    action = name.definition()
    example = example_of(client, action, name.robot)
    if text is None and (example == {} or not action.goal.model_fields):
        return {}
    hint = f", such as {quote(yaml_flow(dict(example)))}" if example else ""
    problem = "the goal is missing" if text is None else f"the goal {shown(text)} is not a mapping"
    raise WrongUse(f"{name.name}: {problem}; give it as YAML{hint}")


def _check_that_time_moves(client: Client) -> None:
    """Print which participants advance time in lockstep; raise an error if there are none."""
    participants = value_of(client, "time/state")["participants"]
    if not participants:
        raise Refused(
            "time stands, as in lockstep no controller takes part: start one, run the world without --clock lockstep, "
            "or let time advance by itself: hmrsim service call /_world/time/set '{clock: realtime}'"
        )
    warn(f"in lockstep, time advances only as far as {', '.join(participants)} allow{'s' * (len(participants) == 1)}")


def _goal_id(text: str | None) -> str | None:
    from hmrsim.protocol.goal import parse_goal_id

    try:
        return None if text is None else parse_goal_id(text)
    except ValueError as error:
        raise WrongUse(f"--goal-id: {error}") from None


@dataclass
class _Report:
    """Prints the progress of a goal, with feedback that takes one line each if *brief*."""

    as_json: bool
    feedback: bool
    brief: bool
    _accepted: bool = field(default=False, init=False)

    def accept(self, goal_id: str) -> None:
        """Print, once, that the goal was accepted."""
        if not (self._accepted or self.as_json):
            show(f"Goal accepted with ID: {goal_id}\n")
        self._accepted = True

    def show_feedback(self, goal_id: str, message: Message) -> None:
        """Print feedback."""
        from hmrsim.cli.goal_text import one_line

        if self.as_json:
            show_json({"goal_id": goal_id, "feedback": message.model_dump(mode="json")})
        elif self.brief:
            show(f"Feedback: {one_line(message)}")
        else:
            show(f"Feedback:\n{_indented(message)}")

    def reject(self, goal_id: str, error: GoalRejectedError) -> None:
        """Print that the goal was rejected."""
        warn(f"Goal was rejected: {error}")
        _refer_to(error.reason)
        if self.as_json:
            show_json(
                {
                    "accepted": False,
                    "goal_id": goal_id,
                    "reason": error.reason,
                    "error_code": error.error_code,
                    "error_msg": error.message,
                }
            )

    def end(self, handle: GoalHandle[Any, Any]) -> None:
        """Print how the goal ended."""
        if self.as_json:
            show_json(_outcome(handle))
        else:
            show(f"Result:\n{_indented(handle.result())}\nGoal finished with status: {handle.status.name}")
        if handle.status is GoalStatus.ABORTED:
            code = getattr(handle.result(), "error_code", "")
            _refer_to(str(getattr(code, "val", code)))

    def interrupt(self, handle: GoalHandle[Any, Any]) -> None:
        """Print how the canceled goal ended, or the last known status."""
        if isinstance(handle.error, GoalRejectedError):
            self.reject(handle.goal_id, handle.error)
        elif self.as_json:
            show_json(_outcome(handle))


def _indented(message: Message) -> str:
    """Return a message as ROS 2 prints feedback and results."""
    from hmrsim.cli.goal_text import without_defaults

    return textwrap.indent(yaml_text(without_defaults(message)), "    ")


def _refer_to(code: str) -> None:
    """Print which command explains a code, if one does."""
    from hmrsim.explanations import explanations

    if code in explanations():
        warn(f"`hmrsim explain {code}` says why that happens, and what to do")


def _outcome(handle: GoalHandle[Any, Any]) -> dict[str, Any]:
    result = handle.result_message
    return {
        "accepted": handle.accepted,
        "goal_id": handle.goal_id,
        "status": int(handle.status),
        "status_name": handle.status.name,
        "result": None if result is None else result.model_dump(mode="json"),
    }


def _send_in_lockstep(client: Client, name: ActionName, goal: Message, *, goal_id: str | None, report: _Report) -> int:
    """Send a goal as a participant in lockstep, and print its progress once it has ended."""
    feedback = (lambda message: report.show_feedback("", message)) if report.feedback else None
    handle: GoalHandle[Any, Any] = client.action_client(name.robot, name.definition()).send_goal(
        goal, goal_id=goal_id, on_feedback=feedback
    )
    with suppress(GoalRejectedError):
        handle.result()
    if handle.accepted:
        report.accept(handle.goal_id)
    return _ended(handle, report)


def _follow(client: Client, name: ActionName, goal: Message, *, goal_id: str | None, report: _Report) -> int:
    """Send a goal and print its progress until it has ended; a signal cancels it."""
    news: queue.SimpleQueue[Message | int | None] = queue.SimpleQueue()
    with on_signals(news.put):
        handle: GoalHandle[Any, Any] = client.action_client(name.robot, name.definition()).send_goal(
            goal,
            goal_id=goal_id,
            on_feedback=news.put if report.feedback else None,
            on_change=lambda _handle: news.put(None),
        )
        while True:
            try:
                item = news.get(timeout=_DRAIN_TIMEOUT if handle.done else _LOOK)
            except queue.Empty:
                if handle.done:
                    return _ended(handle, report)
                continue
            if isinstance(item, int):
                return _cancel(handle, item, report)
            if handle.accepted:
                report.accept(handle.goal_id)
            if item is not None:
                report.show_feedback(handle.goal_id, item)


def _ended(handle: GoalHandle[Any, Any], report: _Report) -> int:
    if isinstance(handle.error, GoalRejectedError):
        report.reject(handle.goal_id, handle.error)
        return ExitCode.FAILED
    if isinstance(handle.error, RequestError) and not isinstance(handle.error, Denied):
        from hmrsim.cli.goal_text import errors_of_reply

        raise errors_of_reply("goal", handle.error)
    handle.result()
    report.end(handle)
    return ExitCode.DONE if handle.status is GoalStatus.SUCCEEDED else ExitCode.FAILED


def _cancel(handle: GoalHandle[Any, Any], signal: int, report: _Report) -> int:
    """Cancel the goal, and wait briefly for it to end."""
    warn("Canceling goal…")
    handle.cancel()
    try:
        handle.result(timeout=_CANCEL_WAIT)
        warn(f"Goal finished with status: {handle.status.name}")
    except GoalRejectedError:
        pass
    except HmrsimError as error:
        warn(str(error))
    report.interrupt(handle)
    return exit_code_of(signal)


def configure(parser: CommandParser) -> None:
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
            "send-goal": ("send a goal and follow it to its end", _configure_send_goal),
        },
    )


def _configure_list(parser: argparse.ArgumentParser) -> None:
    from hmrsim.cli.names import actions, add_list_arguments

    parser.epilog = """\
examples:
  hmrsim action list
  hmrsim action list --show-types --connect tcp/10.0.0.7:7447
  hmrsim action list --json | jq -r '.[].name'"""
    add_list_arguments(parser, actions)


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
    return _primitive(field.metadata) or _name_of(field.annotation)


def _name_of(annotation: Any) -> str:
    arguments = get_args(annotation)
    if not arguments:
        return getattr(annotation, "ros_type", "") or annotation.__name__
    return _primitive(arguments) or f"{_name_of(arguments[0])}[]"


def _primitive(marks: Iterable[object]) -> str | None:
    from hmrsim.interfaces.message import Primitive

    return next((mark.name for mark in marks if isinstance(mark, Primitive)), None)
