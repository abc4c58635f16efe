"""The end of a trial in one process."""

from __future__ import annotations

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.trials.local import LocalTrial
from hmrsim.world.model import World


def test_all_clients_are_closed_even_if_one_is_interrupted(monkeypatch):
    trial, closed = LocalTrial(World(), RunSettings()), []
    first, second = (trial.open_client(name) for name in ("first", "second"))

    def interrupt() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(second, "close", interrupt)
    monkeypatch.setattr(first, "close", lambda: closed.append("first"))
    with pytest.raises(KeyboardInterrupt):
        trial.close()

    assert ["first"] == closed
