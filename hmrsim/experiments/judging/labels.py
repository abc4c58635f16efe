"""How runs end that neither the file of an experiment nor the controller ends, as it is named in results."""

from __future__ import annotations

from typing import Final

CRASHED: Final = "crashed"
"""The ending of a run whose controller raised an error, or ended with an exit code other than 0 and 1."""
TIMEOUT: Final = "timeout"
"""The ending of a run that reached the limit of simulated time."""
HUNG: Final = "hung"
"""The ending of a run that waited or computed for too long, or whose time stood still."""
DEADLOCK: Final = "deadlock"
"""The ending of a run whose controller waits for what can't happen any more."""
MEMORY: Final = "out_of_memory"
"""The ending of a run that took too much memory."""
DIED: Final = "died"
"""The ending of a run whose worker has died, as of a segmentation fault."""
ERROR: Final = "error"
"""The ending of a run that could not be made, as its world or its controller can't be loaded."""
MISHAPS: Final = frozenset({CRASHED, HUNG, DEADLOCK, MEMORY, DIED, ERROR})
"""The endings that say more about a controller, or the machine, than about the mission."""
BUILT_IN: Final = ("succeeded", "failed", TIMEOUT, *sorted(MISHAPS))
"""The endings that runs may have without being defined."""
