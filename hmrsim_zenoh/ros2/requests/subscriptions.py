"""The topics that the simulator reads: RViz's buttons move a robot and send it a goal, and velocities steer it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import zenoh
from pydantic import ValidationError

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.geometry_msgs import TwistStamped
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.protocol.commands import CallService, SendGoal
from hmrsim.protocol.goal import GoalResponse, Refused
from hmrsim.services import registry as all_services
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.codec.types import message_type
from hmrsim_zenoh.ros2.publishing.endpoints import CMD_VEL, GOAL_POSE, INITIAL_POSE, TOPICS
from hmrsim_zenoh.ros2.publishing.parts import FIRST
from hmrsim_zenoh.wire.envelopes import unreadable

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim_zenoh.ros2.codec.types import MessageType
    from hmrsim_zenoh.ros2.wires import RmwZenoh

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class FromTopic:
    """The origin of a command whose answer no client awaits.

    Attributes:
        name: The topic, such as ``/wall_e/goal_pose``.
        log: Logs why the command failed.
    """

    name: str
    log: Callable[[str, str], None]

    def answer(self, answer: object) -> None:
        """Log the answer if the command failed: topics have no reply."""
        if isinstance(answer, GoalResponse) and not answer.accepted:
            self.log(self.name, f"rejected: {answer.error_msg}")
        elif isinstance(answer, Refused):
            self.log(self.name, answer.message)
        elif isinstance(result := getattr(answer, "result", None), Result) and result.result != Result.RESULT_OK:
            self.log(self.name, result.error_message)


def _teleport(robot: str, values: Mapping[str, Any], origin: FromTopic) -> Command:
    service = all_services()["set_entity_state"]
    state = {"header": values["header"], "pose": values["pose"]["pose"]}
    return CallService(service.name, service.request.model_validate({"entity": robot, "state": state}), origin)


def _navigate(robot: str, values: Mapping[str, Any], origin: FromTopic) -> Command:
    return SendGoal(robot, FIRST, all_actions()[FIRST].goal.model_validate({"pose": values}), None, origin)


def _steer(robot: str, values: Mapping[str, Any], origin: FromTopic) -> Command:
    twist, service = values.get("twist", values), all_services()["set_velocity"]
    fields = {"robot": robot, "linear": twist["linear"]["x"], "angular": twist["angular"]["z"]}
    return CallService(service.name, service.request.model_validate(fields), origin)


_COMMANDS: Final[Mapping[str, Callable[[str, Mapping[str, Any], FromTopic], Command]]] = MappingProxyType(
    {INITIAL_POSE: _teleport, GOAL_POSE: _navigate, CMD_VEL: _steer}
)


class Subscriptions:
    """Subscribes to the topics of all robots that become commands.

    Args:
        session: The session to subscribe on, which the caller closes.
        serves: Returns whether a topic is one of the simulator's.
        put: Adds a command to the inbox; it raises `SimulationStopped` after the end.
        log: Logs a topic and why its message had no effect; for any thread.
        max_payload: The largest message in bytes.
    """

    def __init__(
        self,
        session: zenoh.Session,
        wire: RmwZenoh,
        *,
        serves: Callable[[str], bool],
        put: Callable[[Command], None],
        log: Callable[[str, str], None],
        max_payload: int,
    ) -> None:
        self._wire = wire
        types = [(topic, message_type(TOPICS[topic].message)) for topic in _COMMANDS]
        types.append((CMD_VEL, message_type(TwistStamped)))
        self._types = {(topic, type_.dds_name): type_ for topic, type_ in types}
        self._serves = serves
        self._put = put
        self._log = log
        self._max_payload = max_payload
        self._subscribers = [self._subscribe(session, topic, type_) for topic, type_ in types]

    def _subscribe(self, session: zenoh.Session, topic: str, type_: MessageType) -> zenoh.Subscriber[None]:
        key = self._wire.key(f"/*/{topic}", type_.dds_name, type_.hash)
        return session.declare_subscriber(key, zenoh.handlers.Callback(self._take))

    def _take(self, sample: zenoh.Sample) -> None:
        address = self._wire.read(str(sample.key_expr))
        if address is None or not self._serves(address.name):
            return
        _, robot, topic = address.name.split("/")
        payload = sample.payload.to_bytes()
        if len(payload) > self._max_payload:
            self._log(address.name, f"payload of {len(payload)} bytes; at most {self._max_payload} are taken")
            return
        try:
            values = self._types[topic, address.type].decode(payload)
            self._put(_COMMANDS[topic](robot, values, FromTopic(address.name, self._log)))
        except ValidationError as error:
            self._log(address.name, str(unreadable(error)))
        except CdrError as error:
            self._log(address.name, str(error))
        except SimulationStopped:
            _log.debug("a message on %s after the end", address.name)
        except Exception:  # noqa: BLE001 - no message may end the thread
            _log.exception("reading a message on %s", address.name)
