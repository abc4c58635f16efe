"""Diagnosis of a network of simulators and ROS nodes.

`requested` returns a `Snapshot` with the options only, and `gather` one with what is on the network. `problems` judges
a snapshot and makes no queries.
"""

from hmrsim_zenoh.doctor.diagnosis import gather, problems, requested
from hmrsim_zenoh.doctor.snapshot import Problem, Simulator, Snapshot

__all__ = ["Problem", "Simulator", "Snapshot", "gather", "problems", "requested"]
