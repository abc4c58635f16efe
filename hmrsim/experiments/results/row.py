"""The result of one run: a row of the results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hmrsim.experiments.file.plan import Run
    from hmrsim.experiments.judging.measures import Value


@dataclass(frozen=True)
class Row:
    """The result of a run.

    Attributes:
        run: Which one.
        ending: How it has ended: one of the file's labels, ``succeeded`` or ``failed`` as the controller says, or one
            of this module's.
        cause: What the ending alone does not say, such as an error; empty for nothing.
        success: Whether it counts as a success.
        at: When it ended, in simulated seconds; None if it did not begin.
        wall: Wall seconds that it took.
        measures: The measures, by name; None where one has no value.
        reported: What controllers have reported.
        output: The last lines that the controller printed.
        trace: The trace, if it is to be kept.
        fingerprint: The same as that of another replication if both are the same run; empty if the simulator has drawn
            random numbers, or there is one replication only.
        coverage: What it has covered of its trees, packed, if that is to be kept.
    """

    run: Run
    ending: str
    cause: str = ""
    success: bool = False
    at: float | None = None
    wall: float = 0.0
    measures: Mapping[str, Value] = field(default_factory=dict)
    reported: Mapping[str, Any] = field(default_factory=dict)
    output: str = ""
    trace: str = ""
    fingerprint: str = ""
    coverage: bytes = b""
