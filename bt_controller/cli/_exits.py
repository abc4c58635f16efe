"""The exit codes of the commands, and the help texts that several of them share."""

from __future__ import annotations

from typing import Final

from bt_controller.errors import TreeError
from hmrsim.errors import HmrsimError, OutputError

DONE: Final = 0
FAILED: Final = 1
WRONG_USE: Final = 2
NO_SIMULATOR: Final = 3

EXIT_CODES: Final = """\
exit codes:
  0 done; 1 a tree failed, or there is no such robot or action; 2 wrong use, no such tree, or the name of
  the participant is in use; 3 no simulator answers; 130 Ctrl-C, 143 SIGTERM: the goals are canceled (a second
  one does not wait for that)"""

EXAMPLES: Final = """\
examples:
  bt-controller run bt_controller.examples:go_to_pose --robot mocha
  bt-controller run navigate.xml --robot mocha --set goal=kitchen
  bt-controller run missions:patrol --robot mocha latte --connect tcp/10.0.0.7:7447
  bt-controller run missions:patrol --robot mocha latte --secure keys --role nurses
  bt-controller run missions:patrol --robot mocha --json | jq -c 'select(.robot) | [.sim_time, .status]'

TREE is an XML file of BehaviorTree.CPP version 4 with the nodes that `bt-controller nodes` lists, or
MODULE:FUNCTION or FILE.py:FUNCTION; modules are searched in the current folder, too. The function takes the
robot's name or nothing, and returns the root of a py_trees tree; what else it takes is given by name:
'missions.py:deliver(code=7)'. Each robot has its own tree and blackboard."""


def exit_code(error: Exception) -> int | None:
    """Return the exit code of an error with a user-readable text; None for a bug."""
    from bt_controller.core.node import PortError
    from bt_controller.coverage import CoverageError
    from hmrsim_zenoh.errors import (
        BadOptions,
        ConnectionDenied,
        NameTaken,
        PortTaken,
        RequestTimeout,
        SimulationEnded,
        SimulatorGone,
        SimulatorNotFound,
        Unreachable,
    )

    if isinstance(error, (TreeError, PortError, CoverageError, BadOptions, OutputError, PortTaken, NameTaken)):
        return WRONG_USE
    if isinstance(error, (ConnectionDenied, SimulationEnded)):
        return FAILED
    if isinstance(error, (SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout)):
        return NO_SIMULATOR
    return FAILED if isinstance(error, HmrsimError) else None
