"""A report as CSV tables: plain headers, simulated seconds, empty cells for unknown values."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.history.robots import STATES
from hmrsim.report.delays import PARTS

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.report.model import Order, Report, Robot


def table_names() -> tuple[str, ...]:
    """Return the names of the tables' files."""
    return tuple(f"{name}.csv" for name in _HEADERS)


def tables_of(report: Report) -> dict[str, str]:
    """Return the text of each table by the name of its file."""
    rows: dict[str, Iterable[Mapping[str, Any]]] = {
        "goals": map(_row, report.goals),
        "robots": map(_robot, report.robots),
        "waits": map(_row, report.waits),
        "first_causes": map(_row, report.first_causes),
        "states": map(_row, report.states),
        "lanes": map(_row, report.lanes),
        "errors": map(_row, report.errors),
        "faults": map(_row, report.faults),
        "fixtures": map(_row, report.fixtures),
        "orders": map(_order, report.orders),
        "batteries": (
            {"robot": robot, "at": at, "percentage": share}
            for robot, curve in report.batteries.items()
            for at, share in curve
        ),
    }
    return {f"{name}.csv": _csv(_HEADERS[name], rows[name]) for name in _HEADERS}


_HEADERS = {
    "goals": "robot action goal_id accepted ended duration waited waits reroutes distance status error_code error_msg"
    " target target_x target_y",
    "robots": "name type began ended distance energy_used energy_charged battery lowest_battery goals succeeded failed"
    " canceled waits waited queued " + " ".join(STATES),
    "waits": "robot began ended duration kind robots why lane x y goal_id until",
    "first_causes": "cause state seconds robots",
    "states": "robot state began ended duration",
    "lanes": "begin end drives distance seconds waits waited closed",
    "errors": "at robot action goal_id status error_code error_name error_msg target waited_for waiting_since faults"
    " deadlock",
    "faults": "name fault subject robot began ended detail",
    "fixtures": "name kind uses robots seconds share waits waited longest_queue",
    "orders": "name item at to priority state robot placed picked_up ended lead_time lateness " + " ".join(PARTS),
    "batteries": "robot at percentage",
}


def _row(thing: BaseModel) -> dict[str, Any]:
    """Return the cells of a row; names in a list are separated by semicolons."""
    return {
        name: "; ".join(value) if isinstance(value, tuple) else int(value) if isinstance(value, bool) else value
        for name, value in thing
    }


def _robot(robot: Robot) -> dict[str, Any]:
    return _row(robot) | {state: robot.seconds[state] for state in STATES}


def _order(order: Order) -> dict[str, Any]:
    return _row(order) | (dict(order.delay) if order.delay else {})


def _csv(header: str, rows: Iterable[Mapping[str, Any]]) -> str:
    file = io.StringIO()
    writer = csv.DictWriter(file, header.split(), extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return file.getvalue()
