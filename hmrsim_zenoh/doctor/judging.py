"""All checks, in the order in which problems should be solved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.doctor import client_checks, network_checks, ros2_checks, security_checks, simulator_checks

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.problem import Problem
    from hmrsim_zenoh.doctor.snapshot import Snapshot

    Check = Callable[[Snapshot], Iterator[Problem]]

_CHECKS: Final[tuple[Check, ...]] = (
    *network_checks.CHECKS,
    *security_checks.CHECKS,
    *simulator_checks.CHECKS,
    *ros2_checks.CHECKS,
    *client_checks.CHECKS,
)


def problems(snapshot: Snapshot) -> list[Problem]:
    """Return the problems of a snapshot; errors first."""
    found = chain.from_iterable(check(snapshot) for check in _CHECKS)
    return sorted(found, key=lambda problem: problem.severity != "error")
