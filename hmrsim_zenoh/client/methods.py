"""The methods of a robot's classes, each of which does what a verb requests."""

from __future__ import annotations

import inspect
from functools import update_wrapper
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

_SELF: Final = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)


def present_as(verb: Callable[..., Any], method: Callable[..., Any]) -> None:
    """Give a method the name, documentation and signature of its verb, with ``self`` in place of the places."""
    update_wrapper(method, verb)
    signature = inspect.signature(verb)
    _places, *parameters = signature.parameters.values()
    result = signature.return_annotation.removeprefix("Request[").removesuffix("]")
    vars(method)["__signature__"] = signature.replace(parameters=[_SELF, *parameters], return_annotation=result)
