"""The 22 patterns of Menghi et al., "Specification Patterns for Robotic Missions", by their names."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hmrsim.properties.model.conditions import Condition
from hmrsim.properties.model.part import Count, Name, Part, Seconds

Places = Annotated[tuple[Name, ...], Field(min_length=1, max_length=100)]
"""Places, docks or waypoints, in order."""


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
    """Likewise, and no place is reached before the one that precedes it."""

    ordered_visit: Places


class StrictOrderedVisit(VisitPattern):
    """Likewise, and no place is reached twice before the one that follows it."""

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
    """Likewise, and no place is reached before the one that precedes it, in each round."""

    ordered_patrolling: Places


class StrictOrderedPatrolling(PatrollingPattern):
    """Likewise, and no place is reached twice before the one that follows it."""

    strict_ordered_patrolling: Places


class FairPatrolling(PatrollingPattern):
    """A robot reaches each of some places again and again, and none of them twice before each other one."""

    fair_patrolling: Places


class PastAvoidance(Part):
    """A condition does not hold until another one has held."""

    past_avoidance: Condition
    until: Condition


class GlobalAvoidance(Part):
    """A condition never holds."""

    global_avoidance: Condition


class FutureAvoidance(Part):
    """A condition does not hold any more once another one has held."""

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
