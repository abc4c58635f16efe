"""The properties that are built in, one file each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.properties.built_in.controller_lives import ControllerLives
from hmrsim.properties.built_in.goals_end import GoalsEnd
from hmrsim.properties.built_in.mission_ends import MissionEnds
from hmrsim.properties.built_in.no_deadlock import NoDeadlock
from hmrsim.properties.built_in.no_vain_goals import NoVainGoals
from hmrsim.properties.built_in.nobody_stranded import NobodyStranded
from hmrsim.properties.built_in.orders_in_time import OrdersInTime
from hmrsim.properties.built_in.recovers import Recovers

if TYPE_CHECKING:
    from hmrsim.properties.model.built_in import BuiltIn
    from hmrsim.properties.observing.timeline import Timeline
    from hmrsim.properties.results import Tell
    from hmrsim.properties.watcher import Watcher
    from hmrsim.world.model import World

__all__ = ["GoalsEnd", "NoVainGoals", "watchers_of"]


def watchers_of(settings: BuiltIn, world: World, timeline: Timeline, tell: Tell) -> list[Watcher]:
    """Return what watches over the properties that are switched on, in the order of their settings."""
    found: list[Watcher] = []
    if settings.goals_end:
        found.append(GoalsEnd(timeline, tell))
    if settings.no_deadlock:
        found.append(NoDeadlock(settings.no_deadlock, timeline, tell))
    if settings.nobody_stranded:
        batteries = any("battery" in world.robot_type(robot).components for robot in world.robots.values())
        found.append(NobodyStranded(settings.nobody_stranded, timeline, tell, batteries=batteries))
    if settings.orders_in_time:
        found.append(OrdersInTime(timeline, tell))
    if settings.controller_lives:
        found.append(ControllerLives(timeline, tell))
    if settings.no_vain_goals:
        found.append(NoVainGoals(settings.no_vain_goals, timeline, tell))
    if settings.mission_ends:
        found.append(MissionEnds(tell))
    if settings.recovers:
        found.append(Recovers(settings.recovers.within, timeline, tell))
    return found
