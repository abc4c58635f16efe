"""What a page and the server say to each other, as JSON text; payloads are embedded as they came.

Whatever is embedded was read as JSON once and thrown away: anybody may publish below the prefix, and one payload that
is none would make the whole frame unreadable to the page. The reading takes a few microseconds.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import from_json

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

MIN_PERIOD: Final = 0.05
"""Wall seconds between two frames of a subscription, if nothing is said."""

_MAX_PERIOD: Final = 60.0
_MAX_SECONDS: Final = 60.0
_MAX_KEY: Final = 1_000

_Id = Annotated[int, Field(ge=0, lt=2**53)]
_Key = Annotated[str, Field(min_length=1, max_length=_MAX_KEY)]


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    id: _Id


class Subscribe(_Request):
    """Wants the samples of a key; with *latest* only the newest of each key in a frame."""

    op: Literal["subscribe"]
    key: _Key
    latest: bool = False
    every: float = MIN_PERIOD

    @property
    def pause(self) -> float:
        """Wall seconds between two frames."""
        return min(max(self.every, MIN_PERIOD), _MAX_PERIOD)


class Unsubscribe(_Request):
    """Wants no more of them."""

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
    """Return what a page wants.

    Raises:
        ValueError: It can't be read; the text says why, and where.
    """
    try:
        return _REQUEST.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"{where}: {first['msg']}" if where else first["msg"]) from None


def is_json(payload: bytes) -> bool:
    """Return whether a payload can be put into a frame as it is."""
    try:
        from_json(payload, allow_inf_nan=False)
    except ValueError:
        return False
    return True


def embedded(key: str, payload: bytes) -> str | None:
    """Return what a key's payload is in a frame, but for what stands in front; None if it is no JSON."""
    return f"{json.dumps(key)},{payload.decode()}]" if is_json(payload) else None


def samples(entries: Iterable[tuple[int, str]]) -> str:
    """Return the frame of samples, each of which is a subscription's id and what `embedded` made of it."""
    return f'{{"op":"samples","samples":[{",".join([f"[{id_},{text}" for id_, text in entries])}]}}'


def replies(id_: int, texts: Iterable[str]) -> str:
    """Return the frame that answers a get with what `embedded` made of the replies."""
    return f'{{"op":"reply","id":{id_},"replies":[{",".join([f"[{text}" for text in texts])}]}}'


def failure(id_: int, error: str, details: Sequence[dict[str, Any]] = ()) -> str:
    """Return the frame that says why a get has no answer."""
    extra = {"details": [*details]} if details else {}
    return json.dumps({"op": "reply", "id": id_, "error": error, **extra})


def said(op: str, **fields: object) -> str:
    """Return a frame of plain values."""
    return json.dumps({"op": op, **fields})
