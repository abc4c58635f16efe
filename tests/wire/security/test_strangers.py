"""Commands of those who may not give them are not executed; each with its control."""

from __future__ import annotations

import pytest

from tests.cases import case
from tests.wire.security.conftest import over_json, over_ros, strangers

EXECUTED = ["SendGoal", "CancelGoal", "CallService"]


@pytest.mark.parametrize("wire", [over_json, over_ros])
def test_strangers_execute_nothing(secured, tmp_path, wire):
    """Neither without a certificate, nor with one of another authority, expired, revoked, or of another role."""
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
    """The same requests as a stranger's: goals are executed, the fault is not injected."""
    secured.ledger.commands.clear()
    answered = wire(secured.of(name))

    assert (EXECUTED[:2] if wire is over_json else EXECUTED[:1]) == secured.ledger.commands
    assert len(secured.ledger.commands) == len(answered)
