"""``hmrsim service``: the simulator's services, as in ``ros2 service``."""

from __future__ import annotations

import argparse
import json
import queue
import re
import threading
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import registry
from hmrsim.cli import listing, names
from hmrsim.cli.connection import OPERATOR, connected, look_for_simulator
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode, UnknownName, WrongUse
from hmrsim.cli.goal_text import mistakes_in_reply, read_yaml
from hmrsim.cli.output import show, show_json, yaml_text
from hmrsim.cli.services import services
from hmrsim.diagnostics import instead, shown
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim_zenoh.errors import Denied, RequestError, Unreachable
from hmrsim_zenoh.wire.descriptions import plain_values
from hmrsim_zenoh.wire.envelopes import CancelGoalRequest, ExecuteRequest, GetResultRequest, SendGoalRequest
from hmrsim_zenoh.wire.keys import Verb
from hmrsim_zenoh.wire.options import ENVIRONMENT

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.cli.names import Info
    from hmrsim_zenoh.client.client import Client

_EXAMPLES: Final = f"""\
examples:
  hmrsim service list -t
  hmrsim service call /_world/info

{ENVIRONMENT}"""

_LIST_EXAMPLES: Final = f"""\
examples:
  hmrsim service list
  hmrsim service list --show-types --include-hidden-services
  hmrsim service list --json | jq -r '.[].name'

{ENVIRONMENT}"""

_CALL_EXAMPLES: Final = f"""\
exit codes: 0 the service did what was asked; 1 it did not, or there is no such service, robot or action;
2 the request can't be read; 3 no simulator answers

examples:
  hmrsim service call /_world/info --json | jq -r '.robots[].name'
  hmrsim service call /mocha/wait/_action/send_goal '{{goal: {{time: {{sec: 3}}}}}}'
  hmrsim service call /mocha/wait/_action/execute '{{goal: {{time: {{sec: 3}}}}}}'
  hmrsim service call /mocha/wait/_action/cancel_goal
  hmrsim service call /mocha/wait/_action/get_result '{{goal_id: 0123456789abcdef0123456789abcdef}}'

The answer is waited for as long as the simulator is there: get_result and execute answer when the goal has ended.
--timeout is for reaching the simulator. Ctrl-C gives up; the request may be carried out all the same.

{ENVIRONMENT}"""

_TYPE_EXAMPLES: Final = f"""\
examples:
  hmrsim service type /_world/inject_fault
  hmrsim service type /mocha/wait/_action/send_goal

{ENVIRONMENT}"""

_TYPE: Final = re.compile(r"\w+(/\w+)+")
_WILDCARDS: Final = frozenset("*$#?")
_ACTION: Final = "/_action/"
_LOOK: Final = 0.5
_FOR_EVER: Final = 1e6


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim service``."""
    parser.description = "Call the simulator's services, as with `ros2 service`."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    lister = commands.add_parser(
        "list", help="list all services", description="List all services, one a line.", epilog=_LIST_EXAMPLES
    )
    lister.add_argument(
        "-a", "--include-hidden-services", action="store_true", help="list the services of actions, too"
    )
    listing.configure(lister, _names)
    call = commands.add_parser(
        "call", help="call a service", description="Call a service and print its response.", epilog=_CALL_EXAMPLES
    )
    call.add_argument("name", metavar="NAME", help="such as /_world/info")
    call.add_argument("type", metavar="TYPE", nargs="?", help="the service's type, as for `ros2 service call`")
    call.add_argument("request", metavar="REQUEST", nargs="?", help="the request as YAML (default: {})")
    call.add_argument("--json", action="store_true", help="print one JSON object instead of YAML")
    call.set_defaults(function=_call)
    add_connection_options(call)
    kind = commands.add_parser(
        "type", help="print the type of a service", description="Print the type of a service.", epilog=_TYPE_EXAMPLES
    )
    kind.add_argument("name", metavar="NAME", help="such as /_world/info")
    kind.set_defaults(function=_type)
    add_connection_options(kind)


def _names(args: argparse.Namespace, info: Info) -> Iterator[dict[str, Any]]:
    for one in services(info):
        if args.include_hidden_services or not one.hidden:
            yield {"name": one.name, "type": one.ros_type, "hidden": one.hidden}


def _type(args: argparse.Namespace) -> int:
    name = f"/{args.name.removeprefix('/')}"
    with connected(args) as (_, info):
        known = {one.name: one.ros_type for one in services(info)}
        if name not in known:
            raise _unknown(name, known, info)
    show(known[name] or "unknown")
    return ExitCode.DONE


def _call(args: argparse.Namespace) -> int:
    ros_type, request = args.type, args.request
    if ros_type is not None and request is None and not _TYPE.fullmatch(ros_type):
        ros_type, request = None, ros_type
    name = f"/{args.name.removeprefix('/')}"
    if not _WILDCARDS.isdisjoint(name):
        raise WrongUse(f"{args.name!r} has a wildcard; expected the name of one service")
    data = {} if request is None else read_yaml(request, "request")
    payload = _payload(data)
    with connected(args, OPERATOR) as (client, info):
        known = {one.name: one.ros_type for one in services(info)}
        if ros_type is not None and known.get(name, ros_type) != ros_type:
            raise WrongUse(f"{name} is a {known[name]}, not a {ros_type}")
        try:
            answer = _answer(client, f"{client.keys.prefix}{name}", payload)
        except Denied:
            raise
        except RequestError as error:
            if name in known:
                raise mistakes_in_reply("request", error, data, _request_type(name, info)) from None
            raise _unknown(name, known, info, str(error)) from None
        except (Unreachable, ValueError) as error:
            if name in known and isinstance(error, Unreachable):
                raise
            raise _unknown(name, known, info) from None
    response = plain_values("the response", answer)
    _print(response, as_json=args.json)
    return ExitCode.FAILED if _failed(response) else ExitCode.DONE


def _failed(response: object) -> bool:
    """Return whether a response has a simulation_interfaces/msg/Result other than RESULT_OK."""
    result = response.get("result") if isinstance(response, dict) else None
    return isinstance(result, dict) and set(result) == set(Result.model_fields) and result["result"] != Result.RESULT_OK


def _payload(data: object) -> bytes:
    if not isinstance(data, dict):
        raise WrongUse(f"request: expected a mapping such as '{{goal_id: …}}', got {shown(data)}")
    try:
        return json.dumps(data, allow_nan=False).encode()
    except ValueError:
        raise WrongUse("request: NaN and infinity are not valid JSON; expected finite numbers") from None


def _answer(client: Client, key: str, payload: bytes) -> bytes:
    """Return the response of a service, however long that takes.

    Raises:
        SimulatorGone: The simulator has been out of reach for too long.
    """
    answers: queue.SimpleQueue[bytes | Exception] = queue.SimpleQueue()

    def ask() -> None:
        try:
            answers.put(client.get(key, _FOR_EVER, payload=payload))
        except (HmrsimError, ValueError) as error:
            answers.put(error)

    threading.Thread(target=ask, name="hmrsim call", daemon=True).start()
    look = look_for_simulator(client)
    while True:
        try:
            answer = answers.get(timeout=_LOOK)
        except queue.Empty:
            look()
            continue
        if isinstance(answer, Exception):
            raise answer
        return answer


def _request_type(name: str, info: Info) -> type[BaseModel] | None:
    """Return the message that a service of an action reads; None for all that are no such services."""
    owner, _, verb = name.rpartition(_ACTION)
    envelopes: dict[str, type[BaseModel]] = {Verb.SEND_GOAL.value: SendGoalRequest, Verb.EXECUTE.value: ExecuteRequest}
    if verb in envelopes:
        known = registry().get(names.find_action(info, owner).action)
        return envelopes[verb][known.goal] if known else None  # type: ignore[index]  # generic; made as it runs
    others: dict[str, type[BaseModel]] = {
        Verb.CANCEL_GOAL.value: CancelGoalRequest,
        Verb.GET_RESULT.value: GetResultRequest,
    }
    return others.get(verb)


def _unknown(name: str, known: Iterable[str], info: Info, answer: str = "") -> UnknownName:
    owner, found, _ = name.rpartition(_ACTION)
    try:
        if found:
            names.find_action(info, owner)
    except UnknownName as error:
        return error
    except WrongUse:
        pass
    there = list(known)
    near = [one for one in there if one.startswith(f"{owner or '/_world'}/")] or [
        one for one in there if _ACTION not in one
    ]
    rest = instead(name, near)
    return UnknownName(f"no service {name!r}{f': {answer}' if answer and not rest.endswith('?') else rest}")


def _print(response: object, *, as_json: bool) -> None:
    if as_json:
        show_json(response)
    else:
        show(yaml_text(response).rstrip("\n"))
