"""Actions that no robot could serve."""

from __future__ import annotations

from dataclasses import replace

from hmrsim.actions import registry
from hmrsim.simulation import entities


def test_an_action_without_its_component_is_a_warning(monkeypatch, caplog):
    pickup = replace(registry()["pickup"], component="clwa")
    monkeypatch.setattr(entities, "actions", lambda: {"pickup": pickup})

    assert {"pickup": pickup} == entities.installed_actions.__wrapped__()
    assert ["action 'pickup' needs the component 'clwa', which no robot has; did you mean 'claw'?"] == caplog.messages


def test_all_actions_of_hmrsim_have_their_components(caplog):
    assert registry() == entities.installed_actions.__wrapped__()
    assert [] == caplog.messages
