"""The orders of scripts: lines such as ``Go pharmacy`` and ``Grab medicine``, each one goal of an action."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.actions import registry

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.world.model import World


@dataclass(frozen=True)
class Order:
    """One line of a script."""

    text: str
    action: AnyAction
    goal: Message


def read_order(text: str, world: World) -> Order:
    """Return the order of a line of a script.

    Raises:
        ValueError: It is invalid in this world; the text says why, and what is expected.
    """
    known = {action.order.word: action for action in registry().values() if action.order}
    word, _, rest = text.strip().partition(" ")
    action = known.get(word)
    if action is None or action.order is None:
        usages = (f"{order.word} {order.usage}".strip() for a in known.values() if (order := a.order))
        raise ValueError(f"no order begins with {word!r}; there are: {'; '.join(usages)}")
    rest = rest.strip()
    if action.order.usage and not rest:
        raise ValueError(f"{word!r} says too little; expected {word} {action.order.usage}")
    return Order(text, action, action.order.goal(rest, world))
