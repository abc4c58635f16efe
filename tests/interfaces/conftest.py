"""A test that asks for ``message_type`` runs once for each message in hmrsim.interfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.spoken import messages

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrise over the messages, in the order of their ROS types."""
    if "message_type" in metafunc.fixturenames:
        metafunc.parametrize("message_type", messages().values(), ids=lambda cls: cls.ros_type)


@pytest.fixture(scope="session")
def message_types() -> dict[str, type[Message]]:
    """Return all messages by ROS type."""
    return messages()
