"""A secured simulator with a ledger of the commands that it has executed, and sessions of strangers."""

from __future__ import annotations

import json
import shutil
import time
import uuid
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import pytest
import zenoh

from hmrsim.protocol.commands import CallService, CancelGoal, Command, SendGoal
from hmrsim.services import registry
from hmrsim_zenoh.errors import SimulatorNotFound
from hmrsim_zenoh.ros2.wires import RmwZenoh
from hmrsim_zenoh.security.authority import Authority
from hmrsim_zenoh.security.keystore import SESSION, Keystore, Network, own_hosts
from hmrsim_zenoh.wire.enclave import SIMULATOR, Member
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.wire.ros2.client import RosClient, Unanswered, ros_action

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic
    from hmrsim_zenoh.wire.enclave import Enclave

MEMBERS = (
    Member(SIMULATOR, SIMULATOR),
    Member("nurses", "controller", ("wall_e",)),
    Member("porters", "controller", ("eve",)),
    Member("fleet", "controller"),
    Member("former", "operator"),
    Member("viewer", "viewer"),
    Member("operator", "operator"),
)

GOAL = {"goal": {"time": {"sec": 1, "nanosec": 0}}}
FAULT = {"type": "breakdown", "robot": "eve", "duration": 0.1}

REQUESTS = {
    "hmrsim/wall_e/wait/_action/execute": {"goal": {}},
    "hmrsim/wall_e/wait/_action/send_goal": GOAL,
    "hmrsim/wall_e/wait/_action/cancel_goal": {},
    "hmrsim/_world/inject_fault": FAULT,
}


class Ledger:
    """A sink that remembers the commands that change something."""

    def __init__(self) -> None:
        self.commands: list[str] = []

    def emit(self, output: Output) -> None:
        pass

    def wants(self, _topic: Topic) -> bool:
        return False

    def commanded(self, command: Command, _by: str, _now: float) -> None:
        changes = isinstance(command, (SendGoal, CancelGoal))
        if changes or (isinstance(command, CallService) and registry()[command.service].changes_world):
            self.commands.append(type(command).__name__)


@dataclass
class Secured:
    """A simulator that enforces the policy of a keystore, in which `former` has been revoked.

    Attributes:
        options: The options of a client, without an enclave.
        ledger: The executed commands.
    """

    store: Keystore
    options: SessionOptions
    ledger: Ledger = field(default_factory=Ledger)

    def of(self, name: str) -> SessionOptions:
        return replace(self.options, secure=self.store.path, role=name)

    def brief(self, folder: Path, use: Callable[[], object]) -> Enclave:
        """Return an operator whose certificate expires after 20 times the duration of one *use*, but at least 3 s."""
        begin = time.monotonic()
        use()
        return self.store.stranger("operator", (3.0 + 20.0 * (time.monotonic() - begin)) / 86_400, folder)


@pytest.fixture(scope="module")
def secured(tmp_path_factory):
    """Return a secured simulator of the small world, on both wires."""
    path = tmp_path_factory.mktemp("secured") / "keys"
    store = Keystore.create(path, MEMBERS, Network(hosts=own_hosts()))
    shutil.copytree(store.enclave("former").folder, path.with_name("former"))
    store.revoke("former")
    found = Secured(Keystore(path), SessionOptions())
    there = SessionOptions(listen=("tls/127.0.0.1:0",), secure=path)
    with served_world(options=there, wires=(RmwZenoh(),), sinks=(found.ledger,)) as options:
        found.options = options
        yield found


def strangers(secured: Secured, folder: Path) -> dict[str, SessionOptions]:
    """Return the sessions of clients without the right to command, or not this robot, by their defect."""
    store, options = secured.store, replace(secured.options, timeout=0.5)

    def configured(name: str, days: float, authority: Authority | None = None) -> SessionOptions:
        there = store.stranger(name, days, folder / f"{name}{days:g}{bool(authority)}", authority).folder
        return replace(options, zenoh_config=there / SESSION)

    bare = folder / "bare.json5"
    ca = str(store.path / "public" / "ca.cert.pem")
    bare.write_text(json.dumps({"transport": {"link": {"tls": {"root_ca_certificate": ca}}}}), encoding="utf-8")
    return {
        "no certificate": replace(options, zenoh_config=bare),
        "no TLS": replace(options, connect=tuple(each.replace("tls/", "tcp/") for each in options.connect)),
        "another authority": configured("operator", 1.0, Authority.create(1.0)[0]),
        "expired": configured("operator", -1.0),
        "no member": configured("mallory", 1.0),
        "a name with a suffix": configured("operator2", 1.0),
        "revoked": replace(options, zenoh_config=store.path.with_name("former") / SESSION),
        "wrong role": secured.of("viewer"),
        "another robot's controller": secured.of("porters"),
    }


def over_json(options: SessionOptions) -> list[str]:
    """Execute and send a goal, cancel all, and inject a fault over JSON; return the keys that answered."""
    try:
        with open_client(options) as session:
            return [key for key, body in REQUESTS.items() if _answers(session, key, body)]
    except SimulatorNotFound:
        return []


def _answers(session: zenoh.Session, key: str, body: dict[str, Any]) -> bool:
    session.put(key, json.dumps(body))
    return any(reply.ok for reply in session.get(key, payload=json.dumps(body), timeout=PATIENCE))


def over_ros(options: SessionOptions) -> list[str]:
    """Send a goal as a ROS node does; return the names of the services that answered."""
    settings = of_node(options)
    try:
        with RosClient(options.connect[0], **settings) as ros:
            type_ = ros_action("wait").send_goal
            client = ros.service("/wall_e/wait/_action/send_goal", type_)
            goal = {"goal_id": {"uuid": list(uuid.uuid4().bytes)}, "goal": GOAL["goal"]}
            try:
                return [client.name] if client.call(goal)["accepted"] else []
            except Unanswered:
                return []
    except zenoh.ZError:
        return []


def of_node(options: SessionOptions) -> dict[str, Any]:
    """Return the configuration of a ROS node's session, from its file, for `RosClient`."""
    file = options.zenoh_config
    if file is None and options.secure is not None:
        file = options.secure / "enclaves" / str(options.role) / SESSION
    found = {} if file is None else json.loads(file.read_text(encoding="utf-8"))
    transport = found.get("transport", {}).get("link", {})
    return {
        "mode": "client",
        "listen__endpoints": [],
        "connect__timeout_ms": 500,
        "connect__exit_on_failure": True,
        **({"transport__link__tls": transport["tls"]} if transport else {}),
        **({"access_control": found["access_control"]} if "access_control" in found else {}),
    }
