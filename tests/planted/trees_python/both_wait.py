"""A robot that wants the corridor waits for the other one if that wants it, too, so both may wait forever."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Sequence
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo

WAYS = {"wall_e": ("west_mouth", "east_mouth", "north_east"), "eve": ("east_mouth", "west_mouth", "north_west")}


def mission(robots: list[str], *, bug: bool = False) -> Behaviour:
    wishes: list[str] = []
    parts = [_cross(robot, wishes, bug=bug) for robot in robots]
    return Parallel("Change sides", ParallelPolicy.SuccessOnAll(synchronise=True), parts)


def _cross(robot: str, wishes: list[str], *, bug: bool) -> Behaviour:
    mouth, other_mouth, end = WAYS[robot]
    steps = [
        _Wish(robot, wishes),
        patient(GoTo(mouth, robot=robot)),
        _Turn(robot, wishes, yields_to_all=bug),
        patient(GoTo(other_mouth, robot=robot)),
        patient(GoTo(end, robot=robot)),
        _Done(robot, wishes),
    ]
    return Sequence(f"{robot} crosses", memory=True, children=steps)


class _Wish(Behaviour):
    """Announces that a robot wants the corridor."""

    def __init__(self, robot: str, wishes: list[str]) -> None:
        super().__init__(f"{robot} wants the corridor")
        self._robot, self._wishes = robot, wishes
        self._ticks = 0

    def update(self) -> Status:
        self._ticks += 1
        if self._robot == "eve" and self._ticks <= 12:
            return Status.RUNNING
        self._wishes.append(self._robot)
        return Status.SUCCESS


class _Turn(Behaviour):
    """Waits until it is a robot's turn."""

    def __init__(self, robot: str, wishes: list[str], *, yields_to_all: bool) -> None:
        super().__init__(f"It is {robot}'s turn")
        self._robot, self._wishes, self._yields_to_all = robot, wishes, yields_to_all

    def update(self) -> Status:
        if self._yields_to_all:  # the bug: no robot goes first
            free = all(robot == self._robot for robot in self._wishes)
        else:
            free = self._wishes[0] == self._robot
        return Status.SUCCESS if free else Status.RUNNING


class _Done(Behaviour):
    """Withdraws the wish for the corridor."""

    def __init__(self, robot: str, wishes: list[str]) -> None:
        super().__init__(f"{robot} is through")
        self._robot, self._wishes = robot, wishes

    def update(self) -> Status:
        self._wishes.remove(self._robot)
        return Status.SUCCESS
