"""The kinds of properties: temporal operators, formulas, and the 22 patterns of Menghi et al., by their names.

Claudio Menghi, Christos Tsigkanos, Patrizio Pelliccione, Carlo Ghezzi, Thorsten Berger: Specification Patterns for
Robotic Missions. IEEE Transactions on Software Engineering 47 (10), 2021.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Final

from pydantic import Field

from hmrsim.properties.model.conditions import Condition
from hmrsim.properties.model.formulas import Formula
from hmrsim.properties.model.part import Count, Identifier, Name, Part, Seconds, one_of

Places = Annotated[tuple[Name, ...], Field(min_length=1, max_length=100)]
"""Places, docks or waypoints, in order."""


class Always(Part):
    """A condition holds at each instant of the run."""

    always: Condition


class Never(Part):
    """A condition holds at no instant of the run."""

    never: Condition


class Eventually(Part):
    """A condition holds at some instant.

    Attributes:
        within: Simulated seconds from the start of the run; None for any time.
    """

    eventually: Condition
    within: Seconds | None = None


class Sometimes(Part):
    """A condition should hold at some instant of some run: this is never violated, but reported if it never does."""

    sometimes: Condition


class Whenever(Part):
    """Each time that a condition begins to hold, another one holds then or later.

    Attributes:
        whenever: The trigger: an event, or a condition that begins to hold.
        then: The condition that has to hold; ``$robot`` stands for the field ``robot`` of the trigger's event.
        within: Simulated seconds from the trigger; None for any time.
    """

    whenever: Condition
    then: Condition
    within: Seconds | None = None


class Reports(Part):
    """If the controller reports an outcome, a condition holds then.

    Attributes:
        reports: The outcome: ``succeeded`` or ``failed`` as the controller ends, or the label that it gives to
            ``end_run``.
        then: The condition that has to hold at that instant.
    """

    reports: Identifier
    then: Condition


class VisitPattern(Part):
    """A pattern of the places that a robot reaches.

    Attributes:
        within: Simulated seconds from the start of the run; None for any time.
    """

    robot: Name
    within: Seconds | None = None


class Visit(VisitPattern):
    """A robot reaches each of some places, in any order."""

    visit: Places


class SequencedVisit(VisitPattern):
    """A robot reaches some places one after the other; it may reach them before, too."""

    sequenced_visit: Places


class OrderedVisit(VisitPattern):
    """A sequenced visit in which no place is reached before the one that precedes it."""

    ordered_visit: Places


class StrictOrderedVisit(VisitPattern):
    """An ordered visit in which no place is reached twice before the one that follows it."""

    strict_ordered_visit: Places


class FairVisit(VisitPattern):
    """A robot reaches each of some places, and none of them twice before each other one is reached again."""

    fair_visit: Places


class PatrollingPattern(Part):
    """A pattern of the places that a robot reaches again and again.

    Attributes:
        every: Simulated seconds that a round may take: from the start to the end of the first, and from then on.
    """

    robot: Name
    every: Seconds


class Patrolling(PatrollingPattern):
    """A robot reaches each of some places again and again, in any order."""

    patrolling: Places


class SequencedPatrolling(PatrollingPattern):
    """A robot reaches some places one after the other, again and again."""

    sequenced_patrolling: Places


class OrderedPatrolling(PatrollingPattern):
    """A sequenced patrol in which no place is reached before the one that precedes it, in each round."""

    ordered_patrolling: Places


class StrictOrderedPatrolling(PatrollingPattern):
    """An ordered patrol in which no place is reached twice before the one that follows it."""

    strict_ordered_patrolling: Places


class FairPatrolling(PatrollingPattern):
    """A robot reaches each of some places again and again, and none of them twice before each other one."""

    fair_patrolling: Places


class PastAvoidance(Part):
    """A condition does not hold until another one has held."""

    past_avoidance: Condition
    until: Condition


class GlobalAvoidance(Part):
    """A condition holds at no instant of the run, as `Never`."""

    global_avoidance: Condition


class FutureAvoidance(Part):
    """A condition never holds again once another one has held."""

    future_avoidance: Condition
    after: Condition


class UpperRestrictedAvoidance(Part):
    """A condition begins to hold so many times at most."""

    upper_restricted_avoidance: Condition
    count: Count


class ExactRestrictedAvoidance(Part):
    """A condition begins to hold exactly so many times."""

    exact_restricted_avoidance: Condition
    count: Count


class LowerRestrictedAvoidance(Part):
    """A condition begins to hold so many times at least."""

    lower_restricted_avoidance: Condition
    count: Count


class Wait(Part):
    """A condition, such as that a robot is at a place, holds from the start until another one holds."""

    wait: Condition
    until: Condition


class InstantaneousReaction(Part):
    """Whenever a condition holds, another one holds at the same instant."""

    instantaneous_reaction: Condition
    then: Condition


class DelayedReaction(Part):
    """Whenever a condition holds, another one holds then or later.

    Attributes:
        within: Simulated seconds; None for any time.
    """

    delayed_reaction: Condition
    then: Condition
    within: Seconds | None = None


class PromptReaction(Part):
    """Whenever a condition holds, another one holds at the next instant at which something of both changes."""

    prompt_reaction: Condition
    then: Condition


class BoundReaction(Part):
    """A condition holds when another one holds, and only then."""

    bound_reaction: Condition
    then: Condition


class BoundDelay(Part):
    """A condition holds at the instant after another one holds, and only then."""

    bound_delay: Condition
    then: Condition


KINDS: Final[Mapping[str, type[Part]]] = MappingProxyType(
    {
        "always": Always,
        "never": Never,
        "eventually": Eventually,
        "sometimes": Sometimes,
        "whenever": Whenever,
        "reports": Reports,
        "formula": Formula,
        "visit": Visit,
        "sequenced_visit": SequencedVisit,
        "ordered_visit": OrderedVisit,
        "strict_ordered_visit": StrictOrderedVisit,
        "fair_visit": FairVisit,
        "patrolling": Patrolling,
        "sequenced_patrolling": SequencedPatrolling,
        "ordered_patrolling": OrderedPatrolling,
        "strict_ordered_patrolling": StrictOrderedPatrolling,
        "fair_patrolling": FairPatrolling,
        "past_avoidance": PastAvoidance,
        "global_avoidance": GlobalAvoidance,
        "future_avoidance": FutureAvoidance,
        "upper_restricted_avoidance": UpperRestrictedAvoidance,
        "exact_restricted_avoidance": ExactRestrictedAvoidance,
        "lower_restricted_avoidance": LowerRestrictedAvoidance,
        "wait": Wait,
        "instantaneous_reaction": InstantaneousReaction,
        "delayed_reaction": DelayedReaction,
        "prompt_reaction": PromptReaction,
        "bound_reaction": BoundReaction,
        "bound_delay": BoundDelay,
    }
)
"""Properties by the key that tells the kind."""

if TYPE_CHECKING:
    Property = Part
else:
    _keys = f"has a key of {', '.join([*KINDS][:7])} or the name of a pattern, such as ordered_visit"
    Property = one_of(KINDS, "property", "a property such as {never: {robot: eve, at: lab}}", _keys)
"""A property of runs."""
