"""The check for lanes on which robots pass through each other under ``free``.

Policies with reservations see to it that robots don't, so that it says nothing there.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, warning
from hmrsim.geometry import SAME_PLACE
from hmrsim.traffic.policies import registry as policies
from hmrsim.traffic.policies._nearness import near_slots

if TYPE_CHECKING:
    from hmrsim.world.model import World


def check_crossings(world: World) -> Iterator[Finding]:
    """Yield a warning for each lane that crosses another one, or is nearer to it than robots are wide.

    Lanes that share a waypoint are none of these. The world must have no errors.
    """
    policy = policies().get(world.policy)
    if policy is None or policy.rule is not None:
        return
    bases = (world.robot_type(robot).base for robot in world.robots.values())
    radii = sorted(base.radius or 0.0 for base in bases if not base.flies)
    if len(radii) < 2:  # noqa: PLR2004 - no two robots, no meeting
        return
    at = {name: number for number, name in enumerate(world.points)}
    ends = {i: (at[lane.from_], at[lane.to]) for i, lane in enumerate(world.lanes)}
    wide = sum(radii[-2:])
    for i, near in near_slots([*world.points.values()], ends, wide).items():
        later = {j: away for j, away in near.items() if j > i}
        if not later:
            continue
        j, away = next(iter(later.items()))
        lane, other = world.lanes[i], world.lanes[j]
        how, why = "crosses", " without a waypoint"
        if away > SAME_PLACE:
            how, why = f"is {away:.3g} from", f", and two robots need {wide:.3g}"
        more = f" and {len(later) - 1} more" if len(later) > 1 else ""
        yield warning(
            ("lanes", i),
            f"{lane.from_!r}-{lane.to!r} {how} lanes.{j} {other.from_!r}-{other.to!r}{more}{why}: under"
            f" {policy.name!r} robots pass through each other there; 'reserve', 'priority' and 'planned' keep"
            " them apart",
            [lane.from_, lane.to],
        )
