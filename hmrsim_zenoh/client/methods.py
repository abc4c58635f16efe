"""The methods of a robot's classes, each of which does what a verb requests."""

from __future__ import annotations

import inspect
from functools import update_wrapper
from typing import TYPE_CHECKING, Any, Concatenate, Final, ParamSpec, TypeVar

from pydantic import ValidationError

from hmrsim.interfaces.message import Message
from hmrsim.program.users_code import field_errors

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim_zenoh.client.places import NamedPlaces
    from hmrsim_zenoh.client.verbs import Request

P = ParamSpec("P")
R = TypeVar("R", bound=Message)

_SELF: Final = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)


def requested(
    verb: Callable[Concatenate[NamedPlaces, P], Request[R]], places: NamedPlaces, *args: P.args, **kwargs: P.kwargs
) -> Request[R]:
    """Return what a verb requests.

    Raises:
        ValueError: A value is invalid, or there is no place of a name; one line per value.
        TypeError: A target is none.
    """
    try:
        return verb(places, *args, **kwargs)
    except ValidationError as error:
        raise ValueError("\n".join(f"{verb.__name__}: {each}" for each in field_errors(error))) from None


def present_as(verb: Callable[..., Any], method: Callable[..., Any]) -> None:
    """Give a method the name, documentation and signature of its verb, with ``self`` in place of the places."""
    update_wrapper(method, verb)
    signature = inspect.signature(verb)
    _places, *parameters = signature.parameters.values()
    result = signature.return_annotation.removeprefix("Request[").removesuffix("]")
    vars(method)["__signature__"] = signature.replace(parameters=[_SELF, *parameters], return_annotation=result)
