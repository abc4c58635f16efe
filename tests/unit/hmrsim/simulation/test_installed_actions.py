"""Actions that no robot could serve."""

from __future__ import annotations

from dataclasses import replace

from hmrsim.actions import registry
from hmrsim.simulation import installed_actions


def test_an_action_whose_component_does_not_exist_is_warned_of(monkeypatch, caplog):
    """It stays, as it harms nobody."""
    pickup = replace(registry()["pickup"], component="clwa")
    monkeypatch.setattr(installed_actions, "actions", lambda: {"pickup": pickup})

    assert {"pickup": pickup} == installed_actions.installed_actions.__wrapped__()
    assert ["action 'pickup' needs the component 'clwa', which no robot has; did you mean 'claw'?"] == caplog.messages


def test_those_of_hmrsim_have_their_components(caplog):
    """Nothing is warned of."""
    assert registry() == installed_actions.installed_actions.__wrapped__()
    assert [] == caplog.messages
