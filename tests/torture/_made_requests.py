"""Invalid requests: extreme numbers and texts, fields of wrong types, broken bytes."""

from __future__ import annotations

import json
import math
import random
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from hmrsim.actions import registry as actions
from hmrsim.interfaces.action_msgs import CancelGoal
from hmrsim.protocol.goal import WORLD
from hmrsim.services import registry as services
from hmrsim_zenoh.ros2 import keys as ros_keys
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.codec.types import ActionType, ServiceType, action_type, service_type
from hmrsim_zenoh.ros2.names import ros_services
from tests.extremes import NUMBERS, body

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

DEEP: Final[str] = "[" * 3_000 + "]" * 3_000
_WRONG: Final[tuple[str, ...]] = (
    "null",
    "true",
    "[]",
    "{}",
    '"NaN"',
    "NaN",
    "-Infinity",
    "1e999",
    "-1e999",
    "1" + "0" * 400,
    '"\\ud800"',
    '"\\u0000"',
    '"' + "x" * 70_000 + '"',
    DEEP,
    "[" + "1," * 20_000 + "1]",
)
_SPECIAL: Final = [struct.pack("<d", number) for number in (*NUMBERS, math.nan, -math.nan, math.inf, -math.inf, 5e-324)]
_HEADER: Final = 4
_DEEPER: Final = 0.85


@dataclass(frozen=True)
class Made:
    """A random request, valid or malformed.

    Attributes:
        key: Where it goes.
        payload: Its bytes.
        goal_id: The goal's id if it sends a goal, in hex.
        result_key: Where the goal's result is asked for.
        result_payload: The request for it.
        reads: Returns whether a reply accepts a goal; it raises if a reply has not the type that it should have.
        ros: Whether it goes by ROS's wire.
    """

    key: str
    payload: bytes
    reads: Callable[[bytes], bool]
    goal_id: str = ""
    result_key: str = ""
    result_payload: bytes = b""
    ros: bool = False


@dataclass(frozen=True)
class Fleet:
    """The robots and names of the tested world."""

    robots: tuple[str, ...]
    names: tuple[str, ...]
    prefix: str = "hmrsim"


class Maker:
    """Makes the same requests for the same seed."""

    def __init__(self, fleet: Fleet, seed: int) -> None:
        self._chance = random.Random(seed)
        self._fleet = fleet
        self._actions = sorted(actions())
        # A world that is loaded has other names.
        self._services = sorted(set(services()) - {"load_world"})
        self._ros_services = sorted(name for name in ros_services(services()) if name != "/load_world")

    def __iter__(self) -> Iterator[Made]:
        while True:
            yield self._chance.choice((self._json_goal, self._json_service, self._ros_goal, self._ros_service))()

    def _body(self, kind: Any) -> dict[str, Any]:
        return body(kind, self._fleet.names, self._chance.choice)

    def _robot(self, action: str) -> str:
        return WORLD if actions()[action].of_world else self._chance.choice(self._fleet.robots)

    def _json_goal(self) -> Made:
        action = self._chance.choice(self._actions)
        robot, goal_id = self._robot(action), f"{self._chance.getrandbits(128):032x}"
        key = f"{self._fleet.prefix}/{robot}/{action}/_action"
        verb = self._chance.choice(("send_goal",) * 8 + ("cancel_goal", "get_result"))
        if verb == "send_goal":
            values: Any = {"goal_id": goal_id, "goal": self._body(actions()[action].goal)}
        elif verb == "cancel_goal":
            values = {"goal_info": self._body(CancelGoal.Request) or {"goal_id": goal_id}}
        else:
            values = {"goal_id": goal_id}
        if verb != "send_goal":
            return Made(f"{key}/{verb}", self._json(values), _json_accepts)
        result = json.dumps({"goal_id": goal_id}).encode()
        return Made(f"{key}/{verb}", self._json(values), _json_accepts, goal_id, f"{key}/get_result", result)

    def _json_service(self) -> Made:
        name = self._chance.choice(self._services)
        values = self._body(services()[name].request)
        return Made(f"{self._fleet.prefix}/_world/{name}", self._json(values), _json_accepts)

    def _json(self, values: Any) -> bytes:
        """Return values as JSON, with an error in one of four."""
        if self._chance.random() < 3 / 4:
            return json.dumps(values).encode()
        if self._chance.random() < 1 / 2:
            mark = "\x00here\x00"
            text = json.dumps(_with(values, mark, self._chance))
            return text.replace(json.dumps(mark), self._chance.choice(_WRONG), 1).encode()
        return self._broken(json.dumps(values).encode())

    def _broken(self, data: bytes) -> bytes:
        """Return bytes with some of them changed, cut off or doubled."""
        changed = bytearray(data)
        for _ in range(self._chance.choice((1, 1, 2, 8))):
            at = self._chance.randrange(len(changed) + 1)
            match self._chance.randrange(4):
                case 0:
                    changed[at : at + 1] = self._chance.randbytes(1)
                case 1:
                    del changed[at : at + self._chance.choice((1, 4, 64))]
                case 2:
                    changed[at:at] = changed[at : at + self._chance.choice((1, 8, 256))]
                case _:
                    del changed[at:]
        return bytes(changed)

    def _ros_goal(self) -> Made:
        action = self._chance.choice(self._actions)
        robot, goal_id = self._robot(action), f"{self._chance.getrandbits(128):032x}"
        name = f"/{action}/_action" if robot == WORLD else f"/{robot}/{action}/_action"
        type_ = _action(action)
        uuid = {"goal_id": {"uuid": bytes.fromhex(goal_id)}}
        encoded = self._encoded(
            actions()[action].goal, lambda goal: type_.send_goal.request.encode({**uuid, "goal": goal})
        )
        payload = self._cdr(encoded, _HEADER + 16)
        result = type_.get_result.request.encode(uuid)

        def accepts(reply: bytes) -> bool:
            return bool(type_.send_goal.response.decode(reply)["accepted"])

        result_key = _ros_key(f"{name}/get_result", type_.get_result)
        key = _ros_key(f"{name}/send_goal", type_.send_goal)
        return Made(key, payload, accepts, goal_id, result_key, result, ros=True)

    def _ros_service(self) -> Made:
        name = self._chance.choice(self._ros_services)
        service = ros_services(services())[name]
        type_ = _service(name)
        payload = self._encoded(service.request, type_.request.encode)

        def reads(reply: bytes) -> bool:
            type_.response.decode(reply)
            return False

        return Made(_ros_key(name, type_), self._cdr(payload, _HEADER), reads, ros=True)

    def _encoded(self, kind: type[Message], encode: Callable[[Message], bytes]) -> bytes:
        """Return a request that CDR can express, where some numbers are too large for their type."""
        while True:
            with suppress(ValidationError, CdrError):
                return encode(kind.model_validate(self._body(kind)))

    def _cdr(self, data: bytes, begin: int) -> bytes:
        """Return a message with some of its numbers replaced from *begin* on, or with broken bytes."""
        if self._chance.random() < 1 / 4:
            return data[:begin] + self._broken(data[begin:])
        changed = bytearray(data)
        for _ in range(self._chance.choice((0, 1, 2))):
            words = (len(changed) - _HEADER) // 8
            at = _HEADER + 8 * self._chance.randrange(words) if words else begin
            if at >= begin:
                changed[at : at + 8] = self._chance.choice(_SPECIAL)
        return bytes(changed)


def _json_accepts(reply: bytes) -> bool:
    return bool(json.loads(reply, parse_constant=_no_constant).get("accepted"))


def _no_constant(text: str) -> None:
    raise ValueError(f"JSON has no {text}")


def _with(values: Any, mark: str, chance: random.Random) -> Any:
    """Return values with a mark in place of one of them."""
    if isinstance(values, dict) and values and chance.random() < _DEEPER:
        name = chance.choice(list(values))
        return {**values, name: _with(values[name], mark, chance)}
    if isinstance(values, list) and values and chance.random() < _DEEPER:
        at = chance.randrange(len(values))
        return [*values[:at], _with(values[at], mark, chance), *values[at + 1 :]]
    return mark


def _ros_key(name: str, type_: ServiceType) -> str:
    return ros_keys.key(0, name, type_.dds_name, type_.hash)


@cache
def _action(name: str) -> ActionType:
    return action_type(actions()[name])


@cache
def _service(name: str) -> ServiceType:
    return service_type(ros_services(services())[name].ros)
