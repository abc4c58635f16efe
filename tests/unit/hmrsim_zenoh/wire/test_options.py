"""Options of sessions, from the environment."""

from __future__ import annotations

from pathlib import Path

import pytest

from hmrsim_zenoh import BadOptions, SessionOptions


def test_variables_say_what_options_say(monkeypatch):
    """Several values have commas between them; an empty variable is none."""
    for name, text in {
        "CONNECT": "tcp/10.0.0.7:7447, tcp/10.0.0.8:7447",
        "TIMEOUT": "2.5",
        "SECURE": "keys",
        "PREFIX": "",
        "ROLE": "viewer",
    }.items():
        monkeypatch.setenv(f"HMRSIM_{name}", text)

    assert (
        SessionOptions(connect=("tcp/10.0.0.7:7447", "tcp/10.0.0.8:7447"), timeout=2.5, secure=Path("keys"))
        == SessionOptions.from_environment()
    )


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("TIMEOUT", "soon", "HMRSIM_TIMEOUT: 'soon' is not a valid time; expected a number of seconds greater than 0"),
        ("CONNECT", "here", "HMRSIM_CONNECT: "),
        ("MODE", "lonely", "HMRSIM_MODE: no mode 'lonely'; there are peer, client, router"),
    ],
)
def test_a_wrong_variable_is_named(monkeypatch, name, text, message):
    monkeypatch.setenv(f"HMRSIM_{name}", text)

    with pytest.raises(BadOptions, match=message):
        SessionOptions.from_environment()
