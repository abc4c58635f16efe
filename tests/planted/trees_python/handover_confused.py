"""In a handover, the second attempt of the last part goes to the wrong robot."""

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import SuccessIsFailure
from py_trees.timers import Timer
from steps import ATTEMPTS, PAUSE, GoToItem, Holds, LiesAt, Look, bring, patient

from bt_controller.behaviours.robot_actions import GoTo, Pickup, Place

WALL = 9.0


def mission(robots: list[str], *, bug: bool = False) -> Behaviour:
    """Return the tree in which the first robot brings the parcel to the hatch, and the second one to the ward."""
    first, second = robots
    to_hatch = Selector("Have it at the hatch", memory=True, children=[IsEast(first), bring("parcel", "west", first)])
    meet = Parallel(
        "Meet", ParallelPolicy.SuccessOnAll(synchronise=True), [patient(to_hatch), patient(GoTo("east", robot=second))]
    )
    tries: list[Behaviour] = [_take_on(second, 1)]
    for number in range(2, ATTEMPTS + 1):
        again = first if bug else second  # the bug: the name of the other robot
        tries.append(SuccessIsFailure(f"Rest {number}", Timer(f"Repair {number}", PAUSE)))
        tries.append(_take_on(again, number))
    return Sequence("Hand over", memory=True, children=[meet, Selector("Take it on", memory=True, children=tries)])


def _take_on(robot: str, number: int) -> Behaviour:
    """Return one attempt to bring the parcel from the hatch, or from where it was dropped, to the ward."""
    hatch = [LiesAt("parcel", "west", robot), GoTo("east", robot=robot), Pickup("parcel", robot=robot)]
    elsewhere = [GoToItem("parcel", robot), Pickup("parcel", robot=robot)]
    have = [
        Holds("parcel", robot),
        Sequence("From the hatch", memory=True, children=hatch),
        Sequence("From elsewhere", memory=True, children=elsewhere),
    ]
    steps = [
        Selector("Have the parcel", memory=True, children=have),
        GoTo("ward", robot=robot),
        Place("parcel", robot=robot),
    ]
    return Selector(
        f"Try {number}",
        memory=True,
        children=[LiesAt("parcel", "ward", robot), Sequence(f"Bring {number}", memory=True, children=steps)],
    )


class IsEast(Look):
    """Succeeds if the parcel is beyond the wall."""

    def __init__(self, robot: str) -> None:
        super().__init__("Is in the east", robot)

    def update(self) -> Status:
        return Status.SUCCESS if self.item("parcel")["at"][0] > WALL else Status.FAILURE
