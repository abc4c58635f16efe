"""The frames between a page and the server, as JSON text with embedded payloads.

Each payload is validated as JSON before it is embedded, as any program may publish below the prefix and one invalid
payload would make the whole frame unreadable. The validation takes a few microseconds.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import from_json

MIN_PERIOD: Final = 0.05
"""The default and smallest number of wall seconds between two frames of a subscription."""

_MAX_PERIOD: Final = 60.0
_MAX_SECONDS: Final = 60.0
_MAX_KEY: Final = 1_000

_Id = Annotated[int, Field(ge=0, lt=2**53)]
_Key = Annotated[str, Field(min_length=1, max_length=_MAX_KEY)]


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    id: _Id


class Subscribe(_Request):
    """Subscribes to a key expression; with *latest* a frame has only the newest sample of each key."""

    op: Literal["subscribe"]
    key: _Key
    latest: bool = False
    every: float = MIN_PERIOD

    @property
    def pause(self) -> float:
        """Wall seconds between two frames."""
        return min(max(self.every, MIN_PERIOD), _MAX_PERIOD)


class Unsubscribe(_Request):
    """Ends a subscription."""

    op: Literal["unsubscribe"]


class Get(_Request):
    """Sends a query on a key."""

    op: Literal["get"]
    key: _Key
    payload: dict[str, Any] | None = None
    timeout: Annotated[float, Field(gt=0, le=_MAX_SECONDS)] = 5.0


Request = Subscribe | Unsubscribe | Get
_REQUEST: Final[TypeAdapter[Request]] = TypeAdapter(Annotated[Request, Field(discriminator="op")])


def read(text: str) -> Request:
    """Return the request in a frame of a page.

    Raises:
        ValueError: The frame is invalid; the text names the field and the mistake.
    """
    try:
        return _REQUEST.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"{where}: {first['msg']}" if where else first["msg"]) from None


def is_json(payload: bytes) -> bool:
    """Return whether a payload can be embedded in a frame."""
    try:
        from_json(payload, allow_inf_nan=False)
    except ValueError:
        return False
    return True


def embedded(key: str, payload: bytes) -> str | None:
    """Return a key and its payload as the end of an array in a frame; None if the payload is not JSON."""
    return f"{json.dumps(key)},{payload.decode()}]" if is_json(payload) else None


def samples(entries: Iterable[tuple[int, str]]) -> str:
    """Return the frame of samples, each of which is a subscription's id and the result of `embedded`."""
    return f'{{"op":"samples","samples":[{",".join([f"[{id_},{text}" for id_, text in entries])}]}}'


def replies(id_: int, texts: Iterable[str]) -> str:
    """Return the frame that answers a get with replies, each of which is the result of `embedded`."""
    return f'{{"op":"reply","id":{id_},"replies":[{",".join([f"[{text}" for text in texts])}]}}'


def failure(id_: int, error: str, details: Sequence[dict[str, Any]] = ()) -> str:
    """Return the frame with the error of a get."""
    extra = {"details": [*details]} if details else {}
    return json.dumps({"op": "reply", "id": id_, "error": error, **extra})


def frame(op: str, **fields: object) -> str:
    """Return a frame of plain values."""
    return json.dumps({"op": op, **fields})
