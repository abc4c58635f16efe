"""Services without further meaning of their own."""

from __future__ import annotations

from hmrsim.interfaces.message import Bool, Message, String


class Trigger:
    """Trigger something, or ask whether it is so."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The outcome, and a text about it."""

        success: Bool = False
        message: String = ""
