"""Requests of commands to the world's services, whose refusal is an error."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from hmrsim_zenoh.client.client import Client

_OK: Final = 1


class Refused(HmrsimError):
    """The simulator does not do what it was asked for; the text says why."""


def ask(client: Client, service: str, **request: Any) -> dict[str, Any]:
    """Return the response of a service of the world.

    Raises:
        Refused: Its result is not success.
        HmrsimError: As `Client.get`.
    """
    answer = client.get(client.keys.world(service), payload=json.dumps(request).encode())
    response: dict[str, Any] = json.loads(answer)
    result = response.get("result", {"result": _OK})
    if result["result"] != _OK:
        raise Refused(result["error_message"] or f"{service} failed with result {result['result']}")
    return response
