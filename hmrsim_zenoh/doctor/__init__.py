"""What is on a network of simulators and ROS nodes, and what is wrong with it.

`gather` looks, and returns a `Snapshot`; `problems` judges that, and looks at nothing else.
"""

from hmrsim_zenoh.doctor.gathering import gather
from hmrsim_zenoh.doctor.judging import problems
from hmrsim_zenoh.doctor.problem import Problem
from hmrsim_zenoh.doctor.snapshot import Simulator, Snapshot

__all__ = ["Problem", "Simulator", "Snapshot", "gather", "problems"]
