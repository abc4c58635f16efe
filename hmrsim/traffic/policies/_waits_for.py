"""Robots that wait for each other in a circle."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.robots.vehicle import Mobile
    from hmrsim.traffic.admission import Passage


def circle_of(passage: Passage, robot: Mobile) -> list[Mobile]:
    """Return the robots of a circle in which each waits for the next, *robot* first; none if it is in no such circle.

    A slot for several robots becomes free when any of them leaves. So there is a circle only where all for whom
    *robot* waits, directly or not, have to wait themselves.
    """
    waits_for: dict[Mobile, Mobile] = {}
    todo = [robot]
    for waiting in todo:
        blockers = passage.blockers(waiting)
        if not blockers or not all(passage.is_held_up(other) for other in blockers):
            return []
        for other in blockers:
            if other not in waits_for:
                waits_for[other] = waiting
                todo.append(other)
    if robot not in waits_for:
        return []
    circle = [waits_for[robot]]
    while circle[-1] is not robot:
        circle.append(waits_for[circle[-1]])
    return circle[::-1]
