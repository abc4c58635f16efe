"""Who takes part in lockstep: who has come and gone, what each asks for, and for whom time waits."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.protocol.commands import Participation

if TYPE_CHECKING:
    from collections.abc import Collection

    from hmrsim.protocol.commands import Advance
    from hmrsim.protocol.outputs import Granted


@dataclass
class Slot:
    """Where the answer to a command of an advance goes.

    Attributes:
        wakes: Whether whoever sent it wants to be woken for results.
        answer: What came of it.
    """

    wakes: bool
    answer: Any = None


@dataclass
class Participant:
    """Somebody who takes part.

    Attributes:
        name: Its name.
        since: When it was last told something, by the clock of whoever watches it.
        open: What it asks for now; None while it thinks.
        askers: Whom to tell the answer: more than one if it asked again.
        slots: Where the answers to its commands are.
        last: Its last epoch, and what it was granted then.
        token: Whether its liveliness token was ever seen.
    """

    name: str
    since: float
    open: Advance | None = None
    askers: list[Any] = field(default_factory=list)
    slots: list[Slot] = field(default_factory=list)
    last: tuple[int, Granted] | None = None
    token: bool = False


class Participants:
    """All who take part.

    Args:
        awaited: How many have to join before time moves for the first time, or their names.
    """

    def __init__(self, awaited: int | Collection[str]) -> None:
        self._awaited = awaited
        self._here: dict[str, Participant] = {}
        self._known: dict[str, None] = {}
        self._gone: dict[str, str] = {}
        self._goals: dict[str, int] = {}
        self._tokens: dict[str, None] = {}
        self._changes: list[Participation] = []

    def __bool__(self) -> bool:
        """Return whether anybody takes part."""
        return bool(self._here)

    @property
    def names(self) -> tuple[str, ...]:
        """Who takes part, in order."""
        return tuple(sorted(self._here))

    def get(self, name: str) -> Participant | None:
        """Return who has a name; None if nobody does."""
        return self._here.get(name)

    def why_unknown(self, name: str) -> str:
        """Return why nobody of a name takes part."""
        return self._gone.get(name) or f"no participant {name!r}; join first"

    # --- coming and going -----------------------------------------------------------------------------------------

    def add(self, name: str, since: float) -> None:
        """Take somebody in whose name is free."""
        self._here[name] = Participant(name, since, token=name in self._tokens)
        self._known[name] = None
        self._gone.pop(name, None)
        self._changes.append(Participation(name, "joined"))

    def remove(self, name: str, change: str, why: str = "", *, told: str = "") -> None:
        """Let somebody go.

        Args:
            name: Whom.
            change: How, as in `Participation`.
            why: Why.
            told: What it is told if it comes back; that it is to join first if empty.
        """
        del self._here[name]
        if told:
            self._gone[name] = told
        if change == "left":
            # The news that its token has gone may come after it has joined anew with another.
            self._tokens.pop(name, None)
        self._changes.append(Participation(name, change, why))

    def take_changes(self) -> list[Participation]:
        """Return who came and went since this was asked last, in an order that is not the network's."""
        changes, self._changes = sorted(self._changes, key=lambda change: change.participant), []
        return changes

    def lost_token(self, name: str, *, alive: bool) -> bool:
        """Note whether somebody's liveliness token is there; return whether one who takes part has lost it."""
        participant = self._here.get(name)
        if alive:
            self._tokens[name] = None
            if participant:
                participant.token = True
            return False
        self._tokens.pop(name, None)
        return participant is not None and participant.token

    # --- goals ----------------------------------------------------------------------------------------------------

    def goals_of(self, name: str) -> int:
        """Return how many goals were sent under a name."""
        return self._goals.get(name, 0)

    def next_goal(self, name: str) -> int:
        """Count one more goal; return its number."""
        number = self._goals[name] = self.goals_of(name) + 1
        return number

    # --- asking ---------------------------------------------------------------------------------------------------

    @property
    def missing(self) -> list[str]:
        """Who has yet to join for the first time; a number in place of names that are not known."""
        if isinstance(self._awaited, int):
            more = self._awaited - len(self._known)
            return [f"{more} more to join"] if more > 0 else []
        return [name for name in self._awaited if name not in self._known]

    @property
    def thinking(self) -> list[Participant]:
        """Who has yet to ask to advance."""
        # Copied, as whoever watches them does so in a thread of its own.
        return [each for each in list(self._here.values()) if each.open is None]

    @property
    def asking(self) -> list[tuple[Participant, Advance]]:
        """Who has asked to advance, with what it asks for, in the order of names."""
        found = [(each, each.open) for each in self._here.values() if each.open is not None]
        return sorted(found, key=lambda pair: pair[0].name) if len(found) > 1 else found
