"""Rates of simulated time, as ports say them in hertz."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.core.node import PortError

if TYPE_CHECKING:
    from bt_controller.core.node import Node


def period_of(node: Node, port: str) -> float:
    """Return how many seconds a rate leaves between two times.

    Raises:
        PortError: It is no rate.
    """
    rate: float = node.read(port)
    if rate <= 0.0:
        raise PortError(f"{node.name}: port {port!r}: {rate:g} is no rate; a number greater than 0 is expected")
    return 1.0 / rate
