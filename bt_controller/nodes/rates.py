"""Rates of simulated time in hertz, as values of ports."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.core.node import PortError

if TYPE_CHECKING:
    from bt_controller.core.node import Node


def period_of(node: Node, port: str) -> float:
    """Return the period of a rate in seconds.

    Raises:
        PortError: The rate is not positive.
    """
    rate: float = node.read(port)
    if rate <= 0.0:
        raise PortError(f"{node.name}: port {port!r}: {rate:g} is not a rate; expected a number greater than 0")
    return 1.0 / rate
