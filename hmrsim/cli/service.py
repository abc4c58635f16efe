"""``hmrsim service``: the simulator's services, as in ``ros2 service``."""

from __future__ import annotations

import argparse
import json
import queue
import threading
from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

from hmrsim.cli.connection import OPERATOR, connected, received
from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, add_connection_options, add_json
from hmrsim.cli.output import show, show_result, yaml_text
from hmrsim.diagnostics import instead, shown
from hmrsim.errors import HmrsimError
from hmrsim.program.command_line import add_commands
from hmrsim_zenoh.errors import Denied, RequestError, Unreachable
from hmrsim_zenoh.wire.keys import Verb

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.cli.connection import Info
    from hmrsim.program.command_line import CommandParser
    from hmrsim_zenoh.client.client import Client

_WILDCARDS: Final = frozenset("*$#?")
_ACTION: Final = "/_action/"
_NO_TIMEOUT: Final = 1e6
"""Wall seconds that no call takes."""


def configure(parser: CommandParser) -> None:
    """Add the commands of ``hmrsim service``."""
    parser.description = "Call the simulator's services, as with `ros2 service`."
    parser.epilog = """\
examples:
  hmrsim service list -t
  hmrsim service call /_world/info"""
    add_commands(
        parser,
        {
            "list": ("list all services", _configure_list),
            "call": ("call a service", _configure_call),
            "type": ("print the type of a service", _configure_type),
        },
    )


def _configure_list(parser: argparse.ArgumentParser) -> None:
    from hmrsim.cli.names import add_list_arguments, services

    parser.epilog = """\
examples:
  hmrsim service list
  hmrsim service list --show-types --include-hidden-services
  hmrsim service list --json | jq -r '.[].name'"""
    add_list_arguments(parser, services, of_actions="services")


def _configure_call(parser: argparse.ArgumentParser) -> None:
    parser.description = "Call a service and print its response."
    parser.epilog = """\
exit codes: 0 the service succeeded; 1 it did not, or there is no such service, robot or action;
2 the request can't be read; 3 no simulator answers

examples:
  hmrsim service call /_world/info --json | jq -r '.robots[].name'
  hmrsim service call /mocha/wait/_action/send_goal '{goal: {time: {sec: 3}}}'
  hmrsim service call /mocha/wait/_action/execute '{goal: {time: {sec: 3}}}'
  hmrsim service call /mocha/wait/_action/cancel_goal
  hmrsim service call /mocha/wait/_action/get_result '{goal_id: 0123456789abcdef0123456789abcdef}'

The command waits for the response as long as the simulator is running: get_result and execute respond when the goal
has ended. --timeout is for reaching the simulator. Ctrl-C stops waiting; the request may still be carried out."""
    parser.add_argument("name", metavar="NAME", help="such as /_world/info")
    parser.add_argument("type", metavar="TYPE", nargs="?", help="the service's type, as for `ros2 service call`")
    parser.add_argument("request", metavar="REQUEST", nargs="?", help="the request as YAML (default: {})")
    add_json(parser, "print one JSON object instead of YAML")
    parser.set_defaults(function=_call)
    add_connection_options(parser)


def _configure_type(parser: argparse.ArgumentParser) -> None:
    parser.epilog = """\
examples:
  hmrsim service type /_world/inject_fault
  hmrsim service type /mocha/wait/_action/send_goal"""
    parser.add_argument("name", metavar="NAME", help="such as /_world/info")
    parser.set_defaults(function=_type)
    add_connection_options(parser)


def _type(args: argparse.Namespace) -> int:
    from hmrsim.cli.names import service_types

    name = f"/{args.name.removeprefix('/')}"
    with connected(args) as (_, info):
        known = service_types(info)
        if name not in known:
            raise _unknown(name, known, info)
    show(known[name] or "unknown")
    return ExitCode.DONE


def _call(args: argparse.Namespace) -> int:
    from hmrsim.cli.goal_text import errors_of_reply, read_yaml, type_and_text
    from hmrsim.cli.names import service_types
    from hmrsim_zenoh.wire.descriptions import plain_values

    ros_type, request = type_and_text(args.type, args.request, "a service", "request")
    name = f"/{args.name.removeprefix('/')}"
    if not _WILDCARDS.isdisjoint(name):
        raise WrongUse(f"{args.name!r} has a wildcard; expected the name of one service")
    data = {} if request is None else read_yaml(request, "request")
    payload = _payload(data)
    with connected(args, OPERATOR) as (client, info):
        known = service_types(info)
        if ros_type is not None and known.get(name, ros_type) != ros_type:
            raise WrongUse(f"{name} is a {known[name]}, not a {ros_type}")
        try:
            answer = _query(client, f"{client.keys.prefix}{name}", payload)
        except Denied:
            raise
        except RequestError as error:
            if name in known:
                raise errors_of_reply("request", error, data, _request_type(name, info)) from None
            raise _unknown(name, known, info, str(error)) from None
        except (Unreachable, ValueError) as error:
            if name in known and isinstance(error, Unreachable):
                raise
            raise _unknown(name, known, info) from None
    response = plain_values("the response", answer)
    show_result(response, yaml_text(response).rstrip("\n"), as_json=args.json)
    return ExitCode.FAILED if _failed(response) else ExitCode.DONE


def _failed(response: object) -> bool:
    """Return whether a response has a simulation_interfaces/msg/Result other than RESULT_OK."""
    from hmrsim.interfaces.simulation_interfaces import Result

    result = response.get("result") if isinstance(response, dict) else None
    return isinstance(result, dict) and set(result) == set(Result.model_fields) and result["result"] != Result.RESULT_OK


def _payload(data: object) -> bytes:
    if not isinstance(data, dict):
        raise WrongUse(f"request: expected a mapping such as '{{goal_id: …}}', got {shown(data)}")
    try:
        return json.dumps(data, allow_nan=False).encode()
    except ValueError:
        raise WrongUse("request: NaN and infinity are not valid JSON; expected finite numbers") from None


def _query(client: Client, key: str, payload: bytes) -> bytes:
    """Return the response of a service, no matter how long it takes."""
    answers: queue.SimpleQueue[bytes | Exception] = queue.SimpleQueue()

    def ask() -> None:
        try:
            answers.put(client.get(key, _NO_TIMEOUT, payload=payload))
        except (HmrsimError, ValueError) as error:
            answers.put(error)

    threading.Thread(target=ask, name="hmrsim call", daemon=True).start()
    answer = next(answer for answer in received(client, answers) if answer is not None)
    if isinstance(answer, Exception):
        raise answer
    return answer


def _request_type(name: str, info: Info) -> type[BaseModel] | None:
    """Return the request model of an action's service; None for other services."""
    from hmrsim.actions import registry
    from hmrsim.cli.names import find_action
    from hmrsim_zenoh.wire.envelopes import CancelGoalRequest, ExecuteRequest, GetResultRequest, SendGoalRequest

    owner, _, verb = name.rpartition(_ACTION)
    envelopes: dict[str, type[BaseModel]] = {Verb.SEND_GOAL.value: SendGoalRequest, Verb.EXECUTE.value: ExecuteRequest}
    if verb in envelopes:
        known = registry().get(find_action(info, owner).action)
        return envelopes[verb][known.goal] if known else None  # type: ignore[index]  # a generic model, specialized at run time
    others: dict[str, type[BaseModel]] = {
        Verb.CANCEL_GOAL.value: CancelGoalRequest,
        Verb.GET_RESULT.value: GetResultRequest,
    }
    return others.get(verb)


def _unknown(name: str, known: Iterable[str], info: Info, answer: str = "") -> UnknownName:
    """Return the error for an unknown service; *answer* is the simulator's error reply, if it sent one."""
    from hmrsim.cli.names import find_action

    owner, is_action, _ = name.rpartition(_ACTION)
    try:
        if is_action:
            find_action(info, owner)
    except UnknownName as error:
        return error
    except WrongUse:
        pass
    names = list(known)
    similar = [other for other in names if other.startswith(f"{owner or '/_world'}/")]
    rest = instead(name, similar or [other for other in names if _ACTION not in other])
    return UnknownName(f"no service {name!r}{f': {answer}' if answer and not rest.endswith('?') else rest}")
