"""The envelopes of goals, cancels, results, feedback and status on the JSON wire, shared by all actions.

They have the fields of the corresponding ROS types, with a goal's id as 32 hex digits.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Message
from hmrsim.settings.option import MAX_PAYLOAD

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pydantic_core import SchemaValidator

G = TypeVar("G")


class UnreadableError(HmrsimError):
    """A payload can't be read.

    Attributes:
        details: One mapping for each error: ``field`` (dotted path from the message's root), ``message``, ``value``.
    """

    def __init__(self, error: str, details: list[dict[str, Any]] | None = None) -> None:
        self.details = details or [{"field": "", "message": error, "value": None}]
        super().__init__(error)

    def below(self, field: str) -> UnreadableError:
        """Return the same error for a message that is the *field* of a larger one."""
        details = [{**each, "field": ".".join(filter(None, (field, each["field"])))} for each in self.details]
        return UnreadableError("{field}: {message}".format_map(details[0]), details)

    def to_json(self) -> bytes:
        """Return the body of Zenoh's error reply."""
        return json.dumps({"error": str(self), "details": self.details}, allow_nan=False).encode()


class Envelope(BaseModel):
    """The base of envelopes, which are read as messages are: strict, without unknown fields."""

    model_config = Message.model_config


class SendGoalRequest(Envelope, Generic[G]):
    """A goal and, if the client generated one, its id."""

    goal_id: str | None = None
    goal: G


class ExecuteRequest(SendGoalRequest[G], Generic[G]):
    """A goal to execute: the reply stays open until the goal ends."""

    feedback: bool = Field(default=False, description="Whether the simulator also sends the goal's feedback.")


class GoalInfo(Envelope):
    """A goal's id, and the time of its acceptance."""

    goal_id: str = "0" * 32
    stamp: Time = Field(default_factory=Time)


class SendGoalResponse(Envelope):
    """The answer to a goal: its acceptance, or the reason for its rejection."""

    accepted: bool
    goal_id: str
    stamp: Time
    reason: str | None = None
    error_code: int | None = None
    error_msg: str | None = None
    status: int | None = None


class CancelGoalRequest(Envelope):
    """The goals to cancel; by default all."""

    goal_info: GoalInfo = Field(default_factory=GoalInfo)


class CancelGoalResponse(Envelope):
    """The goals that are being canceled; the code is that of action_msgs/srv/CancelGoal."""

    return_code: int
    goals_canceling: list[GoalInfo]


class GetResultRequest(Envelope):
    """The goal whose result is requested."""

    goal_id: str


class GetResultResponse(Envelope, Generic[G]):
    """A goal's final status and result."""

    status: int
    result: G


class Ending(GetResultResponse[G], Generic[G]):
    """A goal's final status and result, and the cause if it did not succeed."""

    cause: str = ""


class ResultStatus(BaseModel):
    """A goal's final status, of a `GetResultResponse` whose result does not matter."""

    model_config = ConfigDict(strict=True)

    status: int


class FeedbackMessage(Envelope, Generic[G]):
    """A feedback message with the id of its goal."""

    goal_id: str
    feedback: G


class GoalStatusEntry(Envelope):
    """The status of a goal, and its id."""

    goal_info: GoalInfo
    status: int


class GoalStatusArray(Envelope):
    """The goals that the server keeps, in order of acceptance."""

    status_list: list[GoalStatusEntry]


@cache
def around(envelope: type[BaseModel], message: type[Message]) -> SchemaValidator:
    """Return the reader of an *envelope* with a *message* of this type; built upon first use."""
    return plain(envelope[message])  # type: ignore[index]  # mypy does not know that the base is generic


@cache
def plain(envelope: type[BaseModel]) -> SchemaValidator:
    """Return the reader of an *envelope* or message without type parameters; built upon first use."""
    envelope.model_rebuild()
    # Plugins of pydantic replace it by a wrapper with the same methods.
    reader: SchemaValidator = envelope.__pydantic_validator__  # type: ignore[assignment]
    return reader


def read(reader: SchemaValidator, payload: bytes, *, max_payload: int = MAX_PAYLOAD) -> Any:
    """Return the model in a *payload*.

    Raises:
        UnreadableError: The payload is too large, not JSON, or not of the reader's type.
    """
    if len(payload) > max_payload:
        raise UnreadableError(f"payload of {len(payload)} bytes; at most {max_payload} are taken")
    if not payload:
        raise UnreadableError("empty payload; expected a JSON object")
    try:
        return reader.validate_json(payload)
    except ValidationError as error:
        raise unreadable(error) from None


def read_often(reader: SchemaValidator, payload: bytes) -> Any:
    """Return the model in a *payload* that clients send repeatedly; equal payloads share one immutable model."""
    if len(payload) > _MAX_KEPT:
        return read(reader, payload)
    return _kept(reader, payload)


_MAX_KEPT = 16_384
"""Bytes of the largest payload whose model is kept."""


@lru_cache(256)
def _kept(reader: SchemaValidator, payload: bytes) -> Any:
    return read(reader, payload)


_OBJECT: Final = "Input should be an object"
_IN_JSON: Final = {"model_type": _OBJECT, "dict_type": _OBJECT, "list_type": "Input should be a valid array"}
"""Messages in JSON's terms for errors that pydantic describes in Python's terms."""


def unreadable(error: ValidationError) -> UnreadableError:
    """Return a validation error as an error of the wire, with JSON's terms even if the input was Python values."""
    details: list[dict[str, Any]] = [
        {
            "field": ".".join(str(part) for part in item["loc"])[:_MAX_SHOWN],
            "message": _IN_JSON.get(item["type"], item["msg"]),
            "value": _shown(item["input"]) if item["type"] != "json_invalid" else None,
        }
        for item in error.errors(include_url=False, include_context=False)[:_MAX_DETAILS]
    ]
    first = details[0]
    return UnreadableError(": ".join(part for part in (first["field"], first["message"]) if part), details)


def unreadable_at(field: str, message: str, value: object) -> UnreadableError:
    """Return the error for one field."""
    return UnreadableError(f"{field}: {message}", [{"field": field, "message": message, "value": _shown(value)}])


_encode = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode

_MAX_DETAILS = 20
_MAX_SHOWN = 200


def _shown(value: object) -> object:
    """Return a value that JSON can represent, shortened if it is long."""
    if value is None or isinstance(value, (bool, int)):
        return value if isinstance(value, bool) or value is None or abs(value) < 2**63 else str(value)[:_MAX_SHOWN]
    if isinstance(value, float):
        return value if value - value == 0 else str(value)
    if isinstance(value, str):
        return value[:_MAX_SHOWN]
    return repr(value)[:_MAX_SHOWN]


def dump(values: Mapping[str, Any]) -> bytes:
    """Return a mapping of plain values as compact JSON."""
    return _encode(values).encode()


MAX_TEXT: Final = 4096
"""Characters of a text in a request, such as a name."""

_TEXT: Final = frozenset({str, str | None})
"""The types of fields that hold a text."""

_SHORT: Final = frozenset({bool, int, float})
"""The types of fields that hold no text."""

_LONG: Final = frozenset({"resource_string", "settings", "goal_id", "commands"})
"""The fields that may be long: files, such as worlds, and what has separate checks: ids, and commands of an advance."""


def read_request(reader: SchemaValidator, payload: bytes, max_payload: int) -> Any:
    """Return the model in the *payload* of a request, whose texts are limited.

    Raises:
        UnreadableError: As `read`; or a text is too long.
    """
    request = read(reader, payload, max_payload=max_payload)
    if len(payload) > MAX_TEXT:
        check_texts_of(request)
    return request


def check_texts_of(message: object) -> None:
    """Check the texts of a message that did not come in a payload.

    Raises:
        UnreadableError: A text is too long.
    """
    kind: Any = type(message)
    texts, others = _fields_with_texts(kind)
    short = texts is None or max(map(len, filter(None, texts(message))), default=0) <= MAX_TEXT
    if short and (others is None or not any(others(message))):
        return
    for path, text in _texts(message):
        if len(text) > MAX_TEXT:
            raise unreadable_at(path, f"a text of {len(text)} characters; at most {MAX_TEXT} are taken", text)


_Read = Callable[[object], Sequence[Any]]


@cache
def _fields_with_texts(kind: Any) -> tuple[_Read | None, _Read | None]:
    """Return what reads the texts in messages of a type, and what reads the fields to be walked; None for none."""
    texts, others = _paths(kind)
    return _reader(texts), _reader(others)


def _reader(paths: list[str]) -> _Read | None:
    if len(paths) != 1:
        return attrgetter(*paths) if paths else None
    return lambda message: [attrgetter(path)(message) for path in paths]


def _paths(kind: Any) -> tuple[list[str], list[str]]:
    """Return the paths of the texts in messages of a type, and of lists and others that may contain further texts."""
    texts: list[str] = []
    others: list[str] = []
    for name, field in getattr(kind, "model_fields", {}).items():
        of: Any = field.annotation
        if name in _LONG or of in _SHORT:
            continue
        if of in _TEXT:
            texts.append(name)
        elif isinstance(of, type) and issubclass(of, BaseModel):
            for found, inner in zip((texts, others), _paths(of), strict=True):
                found += [f"{name}.{path}" for path in inner]
        else:
            others.append(name)
    return texts, others


def _texts(value: object) -> Iterator[tuple[str, str]]:
    """Yield the path of each text in a message, and the text."""
    if isinstance(value, str):
        yield "", value
    elif isinstance(value, BaseModel):
        for name, each in value:
            if name not in _LONG:
                yield from ((f"{name}.{path}".rstrip("."), text) for path, text in _texts(each))
    elif isinstance(value, list):
        for number, each in enumerate(value):
            yield from ((f"{number}.{path}".rstrip("."), text) for path, text in _texts(each))
