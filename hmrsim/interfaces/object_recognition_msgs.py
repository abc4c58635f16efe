"""The types of objects that are detected."""

from __future__ import annotations

from hmrsim.interfaces.message import Message, String


class ObjectType(Message):
    """The key of an object's kind, and the database that knows it."""

    key: String = ""
    db: String = ""
