"""Signal Temporal Logic over signals that are constant between changes, monitored while they come.

Values are robustness: positive where a formula holds, negative where it does not, and the further from zero the surer.
Each sample costs a constant time on average, however long the windows are.
"""

from hmrsim.properties.temporal.formulas import (
    Above,
    Always,
    And,
    Below,
    Eventually,
    Formula,
    Implies,
    Not,
    Or,
    Until,
)
from hmrsim.properties.temporal.online import OnlineMonitor

__all__ = [
    "Above",
    "Always",
    "And",
    "Below",
    "Eventually",
    "Formula",
    "Implies",
    "Not",
    "OnlineMonitor",
    "Or",
    "Until",
]
