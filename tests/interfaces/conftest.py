"""All messages in hmrsim.interfaces; a test that asks for ``message_type`` runs once for each."""

from __future__ import annotations

import importlib
import pkgutil

import pytest

import hmrsim.interfaces
from hmrsim.interfaces.message import Message


def _message_types() -> list[type[Message]]:
    for module in pkgutil.iter_modules(hmrsim.interfaces.__path__, "hmrsim.interfaces."):
        importlib.import_module(module.name)
    found = [cls for cls in Message.__subclasses__() if cls.__module__.startswith("hmrsim.interfaces.")]
    return sorted(found, key=lambda cls: cls.ros_type)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrise over the messages, in the order of their ROS types."""
    if "message_type" in metafunc.fixturenames:
        metafunc.parametrize("message_type", _message_types(), ids=lambda cls: cls.ros_type)


@pytest.fixture(scope="session")
def message_types() -> dict[str, type[Message]]:
    """Return all messages by ROS type."""
    return {cls.ros_type: cls for cls in _message_types()}
