"""General services, whose meaning is that of the service's name."""

from __future__ import annotations

from hmrsim.interfaces.message import Bool, Message, String


class Trigger:
    """Trigger something, or query whether a condition holds."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The outcome, and a text about it."""

        success: Bool = False
        message: String = ""
