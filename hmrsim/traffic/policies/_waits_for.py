"""Vehicles that wait for each other in a cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.traffic.policies._admission import AdmissionControl
    from hmrsim.traffic.policies._vehicle import Vehicle


def waits_for_cycle(admission: AdmissionControl, robot: Vehicle) -> list[Vehicle]:
    """Return the vehicles of a cycle in which each waits for the next, *robot* first; none if it is in no such cycle.

    A slot with room for several vehicles becomes free when any of them leaves. So there is a cycle only where all
    vehicles for which *robot* waits, directly or not, have to wait themselves.
    """
    waits_for: dict[Vehicle, Vehicle] = {}
    todo = [robot]
    for waiting in todo:
        blockers = admission.blockers(waiting)
        if not blockers or not all(admission.is_held_up(other) for other in blockers):
            return []
        for other in blockers:
            if other not in waits_for:
                waits_for[other] = waiting
                todo.append(other)
    if robot not in waits_for:
        return []
    cycle = [waits_for[robot]]
    while cycle[-1] is not robot:
        cycle.append(waits_for[cycle[-1]])
    return cycle[::-1]
