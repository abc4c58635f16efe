"""The actions that are installed, with a warning of those that no robot could serve."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from hmrsim.actions import registry as actions
from hmrsim.components import registry as components
from hmrsim.diagnostics import instead

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction

_log = logging.getLogger(__name__)


@cache
def installed_actions() -> Mapping[str, AnyAction]:
    """Return all actions by name; one whose component does not exist is warned of, once."""
    known = components()
    for action in actions().values():
        if action.component is not None and action.component not in known:
            rest = instead(action.component, known)
            _log.warning("action %r needs the component %r, which no robot has%s", action.name, action.component, rest)
    return actions()
