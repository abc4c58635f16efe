"""The participants in lockstep: the states of each, and the one table of transitions between them.

::

                 ┌───────────────────────────answer──────────────────────────┐
                 ▼                                                            │
    join ──► THINKING ──ask──► ASKING ────────────begin──────────────► GRANTED
              ▲   │             ▲  ▲ │                                  ▲   │
           resume stall     resume │ stall                           resume stall
              │   ▼             │  │ ▼                                  │   ▼
             STALLED ──ask──► UNHEARD  STALLED_ASKING ────begin────► STALLED_GRANTED

Simulated time waits while a participant is THINKING. A stalled participant holds up nothing and receives nothing. Its
requests from before the stall are carried out; those made during the stall are handled when the stall is over.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from enum import Enum
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import stamp
from hmrsim.protocol.commands import Participation
from hmrsim.protocol.goal import Refused, ResultResponse
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged, Receiver

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Advance, GetResult
    from hmrsim.protocol.outputs import Granted

Reported = tuple[str, int, GoalChanged | FeedbackSent]
"""An event that a grant reports: its kind, its time in nanoseconds, and the output."""

NO_KINDS: Final[frozenset[str]] = frozenset()
"""No kind of event."""

_FEEDBACK: Final = frozenset({"feedback"})

_NAME: Final = attrgetter("name")
_STALLED_UNTIL: Final = attrgetter("stalled_until")

_FINAL: Final = (Refused, ResultResponse, bytes)
"""The answers to commands without an event to follow."""


class State(Enum):
    """The state of a participant: which side waits for the other.

    Attributes:
        stalled: Whether time moves without it.
        begins: Whether its commands are applied when the next grant begins.
    """

    THINKING = "thinking"
    """It has not asked yet, and simulated time waits for it."""
    ASKING = "asking"
    """It has asked to advance, and its commands go with the next grant."""
    GRANTED = "granted"
    """Its commands were applied; it is answered at the end of the grant."""
    STALLED = "stalled"
    """It has not asked yet, and simulated time moves without it."""
    UNHEARD = "unheard"
    """It asked during its stall, and its request is handled afterwards."""
    STALLED_ASKING = "stalled_asking"
    """It had asked before its stall, and its commands go with the next grant."""
    STALLED_GRANTED = "stalled_granted"
    """Its commands were applied; it is answered at the end of the first grant after its stall."""

    stalled: bool
    begins: bool

    __hash__ = object.__hash__
    """Enum's own is written in Python."""

    def __init__(self, name: str) -> None:
        self.stalled = name.startswith("stalled") or name == "unheard"
        self.begins = name.endswith("asking")


class Event(Enum):
    """An event in the life of a participant."""

    __hash__ = object.__hash__

    ASK = "ask"
    """It asks to advance."""
    BEGIN = "begin"
    """A grant begins, with its commands."""
    ANSWER = "answer"
    """It is answered."""
    STALL = "stall"
    """Time moves without it for a while."""
    RESUME = "resume"
    """Its stall is over."""


TRANSITIONS: Final[Mapping[tuple[State, Event], State]] = {
    (State.THINKING, Event.ASK): State.ASKING,
    (State.THINKING, Event.STALL): State.STALLED,
    (State.ASKING, Event.BEGIN): State.GRANTED,
    # A reset, or the end of lockstep, answers before a grant begins.
    (State.ASKING, Event.ANSWER): State.THINKING,
    (State.ASKING, Event.STALL): State.STALLED_ASKING,
    (State.GRANTED, Event.ANSWER): State.THINKING,
    (State.GRANTED, Event.STALL): State.STALLED_GRANTED,
    (State.STALLED, Event.ASK): State.UNHEARD,
    (State.STALLED, Event.STALL): State.STALLED,
    (State.STALLED, Event.RESUME): State.THINKING,
    (State.UNHEARD, Event.STALL): State.UNHEARD,
    (State.UNHEARD, Event.RESUME): State.ASKING,
    (State.STALLED_ASKING, Event.BEGIN): State.STALLED_GRANTED,
    (State.STALLED_ASKING, Event.STALL): State.STALLED_ASKING,
    (State.STALLED_ASKING, Event.RESUME): State.ASKING,
    (State.STALLED_GRANTED, Event.STALL): State.STALLED_GRANTED,
    (State.STALLED_GRANTED, Event.RESUME): State.GRANTED,
    # The end of the run is reported to stalled participants, too.
    (State.UNHEARD, Event.ANSWER): State.STALLED,
    (State.STALLED_ASKING, Event.ANSWER): State.STALLED,
    (State.STALLED_GRANTED, Event.ANSWER): State.STALLED,
}
"""All transitions; an event that is not here can't happen in that state."""


class Slot(Receiver):
    """The slot for the answer to a command of an advance.

    Attributes:
        wakes: Whether the participant that sent it wants to be woken for results.
        wanted: The goal whose result is wanted, if that is the command.
        answer: The answer; None before there is one.
        woke: Whether the answer ends the grant, because no event will follow.
    """

    __slots__ = ("_halt", "answer", "wakes", "wanted", "woke")

    def __init__(self, halt: Callable[[], None], *, wakes: bool) -> None:
        self.wakes = wakes
        self.wanted: GetResult | None = None
        self.answer: Any = None
        self.woke = False
        self._halt = halt

    def succeed(self, answer: Any) -> None:
        """Record the answer; end the grant if it counts as a result that wakes the participant."""
        self.answer = answer
        if self.wakes and (isinstance(answer, _FINAL) or not getattr(answer, "accepted", True)):
            # No later event could wake the participant.
            self.woke = True
            self._halt()


@dataclass(slots=True, eq=False)
class Participant:
    """A controller that takes part in lockstep.

    Attributes:
        since: When it last got an answer, by the watchdog's clock.
        token: Whether its liveliness token was ever seen.
        joined_with: The token of its request to join; empty for none.
        state: What is waited for.
        stalled_until: Simulated seconds at which its stall is over; infinite if it is not stalled.
        request: Its open request to advance; None while it thinks.
        askers: The senders to answer: more than one if the request was repeated.
        slots: The answers to its commands.
        last: Its last epoch, and the grant of that epoch.
        kinds: The kinds of events that it asked for last.
        samples: Whether it asked for feedback that does not wake it, which is sampled when it is answered.
        missed: The events of grants that it did not get, as it is stalled.
        behind: An earlier epoch that it may still ask for; None if it may not.
    """

    name: str
    since: float
    token: bool = False
    joined_with: str = ""
    state: State = State.THINKING
    stalled_until: float = math.inf
    request: Advance | None = None
    askers: list[Any] = field(default_factory=list)
    slots: list[Slot] = field(default_factory=list)
    last: tuple[int, Granted] | None = None
    kinds: frozenset[str] = NO_KINDS
    samples: bool = False
    missed: list[Reported] = field(default_factory=list)
    behind: int | None = None

    def ask(self, request: Advance, wall: float) -> None:
        """Take its request to advance."""
        self.state = TRANSITIONS[self.state, Event.ASK]
        self.request, self.since, self.askers = request, wall, [request.reply_to]

    def begin(self) -> Advance:
        """Return the request whose commands are applied now."""
        self.state = TRANSITIONS[self.state, Event.BEGIN]
        if (request := self.request) is None:
            raise AssertionError(f"{self.name} has not asked to advance")
        self.behind, self.kinds = None, kinds_wanted(request) if request.report else request.wake
        self.samples = "feedback" in request.report and "feedback" not in request.wake
        return request

    def answer(self, epoch: int, granted: Granted) -> list[Any]:
        """Take the answer to its request for an epoch, and return the senders to give it to."""
        self.state = TRANSITIONS[self.state, Event.ANSWER]
        self.last = (epoch, granted)
        askers, self.askers = self.askers, []
        self.request, self.behind = None, None
        self.slots, self.missed = [], []
        return askers

    def stall(self, until: float, epoch: int) -> None:
        """Stall it until some time, unless it is stalled for longer; *epoch* is the next one."""
        if self.state is State.THINKING and self.behind is None:
            self.behind = epoch
        self.stalled_until = max(until, self.stalled_until) if self.state.stalled else until
        self.state = TRANSITIONS[self.state, Event.STALL]
        for slot in self.slots:
            slot.wakes = slot.woke = False

    def resume(self, wall: float | None) -> None:
        """End the stall of the participant."""
        self.state = TRANSITIONS[self.state, Event.RESUME]
        self.stalled_until = math.inf
        if wall is not None:
            self.since = wall

    def drop_request(self) -> list[Any]:
        """Forget its open request, as it will be removed; return the senders, which get no other answer."""
        askers, self.askers, self.request = self.askers, [], None
        return askers


@dataclass(slots=True)
class _Expected:
    """A participant that is expected: time moves until then, and waits from then on."""

    at: float
    on_due: Callable[[], None]
    due: bool = False


class Participants:
    """All participants, and those that are to join.

    Args:
        awaited: How many have to join before time moves for the first time, or their names.

    Attributes:
        all: The participants, in the order of their names.
        by_name: The same, to be looked up.
        missing: Those that have yet to join for the first time; a number in place of names that are not known.
        awaited: Who is to join now, by name.
        later: Whether time may move without any request, because a participant is expected later.
        due: When the next stall is over, or the next one is to join, in simulated seconds; infinite for never.
        changes: The changes of participation since the last call of `take_changes`.
    """

    def __init__(self, awaited: int | Collection[str]) -> None:
        self._wanted = awaited
        self.all: list[Participant] = []
        self.awaited: list[str] = []
        self.later = False
        self.due = math.inf
        self.by_name: dict[str, Participant] = {}
        self._known: dict[str, None] = {}
        self._gone: dict[str, str] = {}
        self._goals: dict[str, int] = {}
        self._tokens: dict[str, None] = {}
        self.changes: list[Participation] = []
        self._expected: dict[str, _Expected] = {}
        self._kept: dict[str, None] = {}
        self.missing = self._missing()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the participants, in order."""
        return tuple(map(_NAME, self.all))

    @property
    def thinking(self) -> list[str]:
        """The names of those that time waits for, as they have yet to ask; from any thread."""
        return [each.name for each in list(self.all) if each.state is State.THINKING]

    def why_unknown(self, name: str) -> str:
        """Return why there is no participant of a name."""
        return self._gone.get(name) or f"no participant {name!r}; join first"

    def add(self, name: str, since: float, joined_with: str = "") -> None:
        """Add a participant; its name must be free."""
        participant = self.by_name[name] = Participant(name, since, name in self._tokens, joined_with)
        bisect.insort(self.all, participant, key=lambda each: each.name)
        self._known[name] = None
        self._gone.pop(name, None)
        self.changes.append(Participation(name, "joined"))
        self.missing = self._missing()
        self.expect_no_more(name)

    def remove(self, name: str, change: str, why: str = "", *, error: str = "") -> None:
        """Remove a participant, and wait for it at once if it is to be kept.

        *change* is how it left, as in `Participation`. *error* is the error for its later requests; empty for the
        default, which asks to join first.
        """
        self.all.remove(self.by_name.pop(name))
        if error:
            self._gone[name] = error
        if change == "left":
            # The loss of its token may be reported after it has joined again with another token.
            self._tokens.pop(name, None)
        self.changes.append(Participation(name, change, why))
        self.expect_no_more(name)
        if name in self._kept:
            self._expected[name] = _Expected(0.0, lambda: None, due=True)
        self._look_ahead()

    def take_changes(self) -> list[Participation]:
        """Return the changes since the last call in the order of names, which does not depend on the network."""
        changes, self.changes = sorted(self.changes, key=lambda change: change.participant), []
        return changes

    def lost_token(self, name: str, *, alive: bool) -> bool:
        """Record whether a liveliness token exists; return whether a participant has lost its token."""
        participant = self.by_name.get(name)
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
        number = self._goals[name] = self._goals.get(name, 0) + 1
        return number

    def expect(self, name: str, at: float, on_due: Callable[[], None]) -> None:
        """Expect a participant to join at some time: time waits for it from then on.

        Args:
            name: The participant that joins; empty to continue from there without one.
            at: When; infinite for never.
            on_due: Called at that time; it must not change the expected participants.
        """
        self._expected[name] = _Expected(at, on_due)
        self._look_ahead()

    def expect_no_more(self, name: str) -> None:
        """Stop expecting a participant."""
        if self._expected.pop(name, None):
            self._look_ahead()

    def keep(self, name: str) -> None:
        """Expect a participant to join again at once whenever it leaves."""
        self._kept[name] = None

    def expect_nobody(self) -> None:
        """Wait for no absent participant, including those marked by `keep`."""
        self._expected.clear()
        self._kept.clear()
        self._look_ahead()

    def expect_only_those_that_come(self) -> None:
        """Forget expected participants that never come, so that time waits."""
        self._expected = {name: each for name, each in self._expected.items() if each.at < math.inf}
        self._look_ahead()

    def stall(self, name: str, until: float, epoch: int) -> None:
        """Stall a participant until some time, unless it is stalled for longer; *epoch* is the next one."""
        if participant := self.by_name.get(name):
            participant.stall(until, epoch)
            self._look_ahead()

    def arrive(self, now: float, wall: float | None = None) -> None:
        """End the stalls that are over, and have those awaited that are to join now."""
        if stamp(self.due) > stamp(now):
            return
        for participant in self.all:
            if stamp(participant.stalled_until) <= stamp(now):
                participant.resume(wall)
        for name, each in sorted(self._expected.items()):
            if not each.due and each.at < math.inf and stamp(each.at) <= stamp(now):
                each.due = True
                each.on_due()
                if not name:
                    del self._expected[name]
        self._look_ahead()

    def shift(self, seconds: float) -> None:
        """Shift stalls and expected participants after time was reset by some seconds; the remaining times stay."""
        for participant in self.all:
            participant.stalled_until -= seconds
        for each in self._expected.values():
            each.at -= seconds
        self._look_ahead()

    def _missing(self) -> list[str]:
        if isinstance(self._wanted, int):
            more = self._wanted - len(self._known)
            return [f"{more} more to join"] if more > 0 else []
        return [name for name in self._wanted if name not in self._known]

    def _look_ahead(self) -> None:
        """Compute what follows from the expected participants and from stalls."""
        awaited, later = [], []
        for name, each in self._expected.items():
            if each.due:
                awaited.append(name)
            else:
                later.append(each.at)
        self.awaited, self.later = sorted(awaited), bool(later)
        self.due = min((*later, *map(_STALLED_UNTIL, self.all)), default=math.inf)


def kinds_wanted(request: Advance) -> frozenset[str]:
    """Return the kinds of events to record for a participant as they happen."""
    return request.wake | (request.report - _FEEDBACK) if request.report else request.wake
