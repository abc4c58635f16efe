"""Commands without permission are not executed, each compared with a permitted one."""

from __future__ import annotations

import json
import time

import pytest

from hmrsim_zenoh.wire.session import open_client
from tests.cases import case
from tests.patience import PATIENCE
from tests.wire.security.conftest import REQUESTS, over_json, over_ros, strangers

EXECUTED = ["SendGoal", "SendGoal", "CancelGoal", "CallService"]


@pytest.mark.parametrize("wire", [over_json, over_ros])
def test_strangers_execute_nothing(secured, tmp_path, wire):
    """Strangers have no certificate, or one that is expired, revoked, of another authority, or of another role."""
    secured.ledger.commands.clear()
    for what, options in strangers(secured, tmp_path).items():
        with case(what):
            assert [] == wire(options)
    # Requests of one simulator are served in order: what came before would be in the ledger by now.
    assert wire(secured.of("operator"))

    assert (EXECUTED if wire is over_json else EXECUTED[:1]) == secured.ledger.commands


@pytest.mark.parametrize("name", ["nurses", "fleet"])
@pytest.mark.parametrize("wire", [over_json, over_ros])
def test_a_controller_drives_its_robots_and_commands_no_world(secured, wire, name):
    """This is the control: the strangers' requests execute goals here, and inject no fault."""
    secured.ledger.commands.clear()
    # ROS declares services a moment after a node has come.
    end = time.monotonic() + PATIENCE
    while not (answered := wire(secured.of(name))) and time.monotonic() < end:
        pass

    assert (EXECUTED[:3] if wire is over_json else EXECUTED[:1]) == secured.ledger.commands
    assert len(secured.ledger.commands) == len(answered)


@pytest.mark.parametrize("name", ["viewer", "porters", "operator"])
def test_queries_for_earlier_values_command_nothing(secured, name):
    """All members may query earlier values of any key, so requests must not be served there."""
    secured.ledger.commands.clear()
    with open_client(secured.of(name)) as session:
        for key, body in REQUESTS.items():
            for end in ("@adv", "@adv/x", "@adv/**"):
                with case(f"{key}/{end}"):
                    assert [] == list(session.get(f"{key}/{end}?_anyke", payload=json.dumps(body), timeout=5.0))
        earlier = list(session.get("hmrsim/_world/info/@adv/**?_anyke", timeout=5.0))
    # Requests of one simulator are served in order: what came before would be in the ledger by now.
    over_json(secured.of("operator"))

    assert ["hmrsim/_world/info"] == [str(reply.ok.key_expr) for reply in earlier]
    assert EXECUTED == secured.ledger.commands
