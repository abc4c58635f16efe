"""The participants in lockstep: joins and leaves, requests to advance, and the participants that time waits for."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.protocol.commands import Participation
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Advance, GetResult
    from hmrsim.protocol.outputs import Granted

Told = tuple[str, int, GoalChanged | FeedbackSent]
"""An event that participants are told of with a grant: its kind, when it was in nanoseconds, and what it is."""


@dataclass
class Slot:
    """Where the answer to a command of an advance goes.

    Attributes:
        wakes: Whether the participant that sent it wants to be woken for results.
        wanted: The goal whose result is wanted, if that is the command.
        answer: The answer; None before there is one.
        woke: Whether the answer ends the grant, as no event would tell of more.
    """

    wakes: bool
    wanted: GetResult | None = None
    answer: Any = None
    woke: bool = False


@dataclass
class Participant:
    """A participant.

    Attributes:
        since: When it last got an answer, by the watchdog's clock.
        open: Its open request to advance; None while it thinks.
        askers: The senders to answer: more than one if the request was repeated.
        slots: The answers to its commands.
        last: Its last epoch, and the grant of that epoch.
        token: Whether its liveliness token was ever seen.
        joined_with: The token of its request to join; empty for none.
        begun: Whether the commands of its open request were applied, so that it gets the next grant.
        early: Whether its open request came before it was stalled.
        kinds: The kinds of events that it wants to be told of, as it last said.
        missed: The events of grants that it did not get, as it is stalled.
        behind: The epoch that it may ask for though there have been later ones; None if there is none.
    """

    name: str
    since: float
    open: Advance | None = None
    askers: list[Any] = field(default_factory=list)
    slots: list[Slot] = field(default_factory=list)
    last: tuple[int, Granted] | None = None
    token: bool = False
    joined_with: str = ""
    begun: bool = False
    early: bool = False
    kinds: frozenset[str] = frozenset()
    missed: list[Told] = field(default_factory=list)
    behind: int | None = None


class Participants:
    """All participants.

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
        """Return whether there is a participant."""
        return bool(self._here)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the participants, in order."""
        return tuple(sorted(self._here))

    def get(self, name: str) -> Participant | None:
        """Return the participant of a name; None if there is none."""
        return self._here.get(name)

    def why_unknown(self, name: str) -> str:
        """Return why there is no participant of a name."""
        return self._gone.get(name) or f"no participant {name!r}; join first"

    def add(self, name: str, since: float, joined_with: str = "") -> None:
        """Add a participant; its name must be free."""
        self._here[name] = Participant(name, since, token=name in self._tokens, joined_with=joined_with)
        self._known[name] = None
        self._gone.pop(name, None)
        self._changes.append(Participation(name, "joined"))

    def remove(self, name: str, change: str, why: str = "", *, error: str = "") -> None:
        """Remove a participant.

        *change* says how it left, as in `Participation`; *error* is the error for its later requests, empty for the
        one that says to join first.
        """
        del self._here[name]
        if error:
            self._gone[name] = error
        if change == "left":
            # The loss of its token may be reported after it has joined again with another token.
            self._tokens.pop(name, None)
        self._changes.append(Participation(name, change, why))

    def take_changes(self) -> list[Participation]:
        """Return the changes since the last call in the order of names, which does not depend on the network."""
        changes, self._changes = sorted(self._changes, key=lambda change: change.participant), []
        return changes

    def lost_token(self, name: str, *, alive: bool) -> bool:
        """Record whether a liveliness token is there; return whether a participant has lost its token."""
        participant = self._here.get(name)
        if alive:
            self._tokens[name] = None
            if participant:
                participant.token = True
            return False
        self._tokens.pop(name, None)
        return participant is not None and participant.token

    def goals_of(self, name: str) -> int:
        """Return how many goals were sent under a name."""
        return self._goals.get(name, 0)

    def next_goal(self, name: str) -> int:
        """Count one more goal; return its number."""
        number = self._goals[name] = self.goals_of(name) + 1
        return number

    @property
    def all(self) -> list[Participant]:
        """All of them, in the order in which they have joined."""
        return list(self._here.values())

    @property
    def missing(self) -> list[str]:
        """The participants that have yet to join for the first time; a number in place of names that are not known."""
        if isinstance(self._awaited, int):
            more = self._awaited - len(self._known)
            return [f"{more} more to join"] if more > 0 else []
        return [name for name in self._awaited if name not in self._known]

    @property
    def thinking(self) -> list[Participant]:
        """The participants that have yet to ask to advance."""
        # Copied, as the watchdog reads it in a thread of its own.
        return [each for each in list(self._here.values()) if each.open is None]

    @property
    def asking(self) -> list[tuple[Participant, Advance]]:
        """The participants that have asked to advance, with their requests, in the order of names."""
        found = [(each, each.open) for each in self._here.values() if each.open is not None]
        return sorted(found, key=lambda pair: pair[0].name) if len(found) > 1 else found
