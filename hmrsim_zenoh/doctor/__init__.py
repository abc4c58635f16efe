"""What is on a network of simulators and ROS nodes, and what is wrong with it.

`asked_for` says where to look, and `gather` looks: both return a `Snapshot`. `problems` judges that, and looks at
nothing else.
"""

from hmrsim_zenoh.doctor.gathering import asked_for, gather
from hmrsim_zenoh.doctor.judging import problems
from hmrsim_zenoh.doctor.problem import Problem
from hmrsim_zenoh.doctor.snapshot import Simulator, Snapshot

__all__ = ["Problem", "Simulator", "Snapshot", "asked_for", "gather", "problems"]
