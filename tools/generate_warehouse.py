"""Writes ``maps/warehouse.yaml``: a hundred robots of seven types, too many to place by hand.

::

    python tools/generate_warehouse.py
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count, pairwise, product
from pathlib import Path
from typing import Final, NamedTuple

FILE: Final = Path(__file__).resolve().parents[1] / "maps" / "warehouse.yaml"

_HEAD: Final = """\
# yaml-language-server: $schema=../schemas/world.schema.json
#
# A warehouse, in meters: a hundred robots of seven types between racks, one-way aisles and packing stations.
# tools/generate_warehouse.py writes this file: change that, and run it.
#
#     y 50  parking and chargers: a one-way street north of each aisle, two of them joined at their ends
#     y 42  northern main aisle, a lane to the east and one to the west
#           racks: aisles a to m, one-way in turn to the north and to the south
#     y 26.5  cross aisle, to the east
#           racks
#     y 11  southern main aisle, a lane to the east and one to the west
#     y 6   packing stations, driven through from west to east
#
# Goods come in at the west, where the dock road leads north, and go out at the east, where it leads south. Docks are
# driven through, too. All lanes but those of the bays are one-way, and each robot has its own bay, so that no
# robots meet head-on.
name: warehouse
units: m
bounds: [0, 0, 80, 52]
seed: 7
traffic: {policy: reserve, patience: null, waypoint_capacity: 2, lane_capacity: 2}
"""

_SOUTH, _CROSS, _NORTH, _TOP = 11.0, 26.5, 42.0, 50.4
_SHELVES: Final = (15.0, 18.75, 22.5, 30.5, 34.25, 38.0)
_RACKS: Final = ((13.0, 24.5), (28.5, 40.0))
_LANE: Final = 0.8
"""How far the two lanes of a main aisle are from its middle."""
_PARKING: Final = (44.2, 45.8, 47.4, 49.0)
_DOCK_STOPS: Final = tuple(14 + 2.5 * i for i in range(11))
_GATE: Final = 1.5
"""Half of a gate's width."""

_GOODS: Final = {
    "a": ("phone", 0.2),
    "b": ("kettle", 1.2),
    "c": ("toaster", 1.6),
    "d": ("chair", 7.0),
    "e": ("drill", 2.1),
    "f": ("book", 0.6),
    "g": ("blender", 2.6),
    "h": ("boots", 1.8),
    "i": ("tyre", 9.5),
    "j": ("printer", 4.8),
    "k": ("lamp", 0.9),
    "l": ("skillet", 3.0),
    "m": ("parquet", 18.0),
}
"""What lies in each aisle, and its weight in kg."""

_RUSH: Final = 1500
"""Seconds in which all that is to be fetched is asked for."""

_ROBOT_TYPES: Final = """\
  # Small and fast: a single light piece at a time.
  shuttle:
    base: {speed: 2.5, acceleration: 1.5, turning_rate: 3.0, radius: 0.3}
    components: {claw: {reach: 1.3, max_weight: 1.0, handling_time: 1.5}, battery: {capacity: 2400}}
  # Most of the work: from the shelf to a packing station.
  picker:
    base: {speed: 1.4, acceleration: 0.8, turning_rate: 1.6, radius: 0.35}
    components: {claw: {reach: 1.4, max_weight: 5.0, handling_time: 3}, battery: {capacity: 3600}}
  # What is too heavy for a picker.
  lifter:
    base: {speed: 0.9, acceleration: 0.5, turning_rate: 1.0, radius: 0.5}
    components: {claw: {reach: 1.5, max_weight: 25.0, handling_time: 6}, battery: {capacity: 7200}}
  # Slow and strong: pallets from the inbound docks to the racks.
  forklift:
    base: {speed: 0.8, acceleration: 0.3, turning_rate: 0.5, radius: 0.6}
    components: {claw: {reach: 1.6, max_weight: 1000.0, handling_time: 12}, battery: {capacity: 14400}}
  # Pulls trolleys from dock to dock.
  tug:
    base: {speed: 1.5, acceleration: 0.4, turning_rate: 0.6, radius: 0.6}
    components: {battery: {capacity: 10800}}
  # Is loaded by people: parcels from the packing stations to the outbound docks.
  parcel_cart:
    base: {speed: 1.8, acceleration: 1.0, turning_rate: 2.0, radius: 0.4}
    components: {battery: {capacity: 4800}}
  # Counts what is on the shelves.
  inspector:
    base: {speed: 0.6, radius: 0.25}
    components: {battery: {capacity: 1800}}
"""

_FACING_EAST, _FACING_WEST = 0.0, 3.1416


class _Bay(NamedTuple):
    """A parking bay: the waypoint and the robot's heading."""

    name: str
    yaw: float


@dataclass
class _World:
    """The parts of the file: the lines of each section."""

    waypoints: list[str] = field(default_factory=list)
    lanes: list[str] = field(default_factory=list)
    walls: list[str] = field(default_factory=list)
    places: list[str] = field(default_factory=list)
    docks: list[str] = field(default_factory=list)
    items: list[str] = field(default_factory=list)
    robots: list[str] = field(default_factory=list)
    bays: list[_Bay] = field(default_factory=list)

    def chapter(self, title: str) -> None:
        """Head the waypoints and lanes that follow."""
        self.waypoints.append(f"  # {title}")
        self.lanes.append(f"  # {title}")

    def waypoint(self, name: str, x: float, y: float, *, capacity: int = 1) -> str:
        """Add a waypoint; return its name."""
        at = f"[{x:g}, {y:g}]"
        self.waypoints.append(f"  {name}: {at if capacity == 1 else f'{{at: {at}, capacity: {capacity}}}'}")
        return name

    def road(self, names: Sequence[str], limit: float) -> None:
        """Add one-way lanes through waypoints in this order."""
        self.lanes += [f"  - {{from: {a}, to: {b}, one_way: true, speed_limit: {limit:g}}}" for a, b in pairwise(names)]

    def driveway(self, road: str, bay: str) -> None:
        """Add the lane that leads from a road to a bay and back."""
        self.lanes.append(f"  - {{from: {road}, to: {bay}, speed_limit: 0.5}}")

    def wall(self, *points: tuple[float, float]) -> None:
        """Add a wall."""
        self.walls.append(f"  - {_outline(points)}")

    def solid(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """Add an obstacle with straight sides."""
        self.walls.append(f"  - solid: {_outline([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])}")


def generate() -> str:
    """Return the text of the world file."""
    world = _World()
    _lay_out_aisles(world)
    _lay_out_packing(world)
    _lay_out_docks(world)
    _lay_out_parking(world)
    _build(world)
    _stock(world)
    _man(world)
    sections = {
        "waypoints": world.waypoints,
        "lanes": world.lanes,
        "walls": world.walls,
        "places": world.places,
        "docks": world.docks,
        "items": world.items,
        "robot_types": _ROBOT_TYPES.splitlines(),
        "robots": world.robots,
    }
    return "\n".join([_HEAD, *("\n".join([f"{key}:", *lines, ""]) for key, lines in sections.items())])


def _x(aisle: str) -> float:
    return 16.0 + 4 * [*_GOODS].index(aisle)


def _northward(aisle: str) -> bool:
    return [*_GOODS].index(aisle) % 2 == 0


def _outline(points: Sequence[tuple[float, float]]) -> str:
    return f"[{', '.join(f'[{x:g}, {y:g}]' for x, y in points)}]"


# --- the floor ------------------------------------------------------------------------------------------------------


def _lay_out_aisles(world: _World) -> None:
    for aisle in _GOODS:
        world.chapter(f"Aisle {aisle}, to the {'north' if _northward(aisle) else 'south'}.")
        keys = ("south_e", "south_w", "1", "2", "3", "cross", "4", "5", "6", "north_e", "north_w")
        mains = (main + side for main in (_SOUTH, _NORTH) for side in (-_LANE, _LANE))
        stops = sorted([*mains, _CROSS, *_SHELVES])
        names = [world.waypoint(f"{aisle}_{key}", _x(aisle), y) for key, y in zip(keys, stops, strict=True)]
        world.road(names if _northward(aisle) else names[::-1], 1.2)


def _lay_out_packing(world: _World) -> None:
    """Add the packing stations, each with room for three robots and a separate exit."""
    aisles = [*_GOODS]
    for number, (aisle, after) in enumerate(zip(aisles[::2], aisles[1::2], strict=False), start=1):
        name = f"pack_{number}"
        world.chapter(f"Packing station {number}.")
        world.waypoint(name, _x(aisle), 6, capacity=3)
        leave = world.waypoint(f"{name}_exit", _x(after), 6)
        world.road([f"{aisle}_south_e", name, leave, f"{after}_south_e"], 0.8)
        world.places.append(f"  {name}: {{at: [{_x(aisle):g}, 6]}}")


def _lay_out_docks(world: _World) -> None:
    """Add the dock roads, and the main aisles that lead from one to the other."""
    west = _dock_road(world, "west", "inbound", 4.5, -2.0)
    east = _dock_road(world, "east", "outbound", 75.5, 2.0)
    world.lanes.append("  # The main aisles, a lane each way, and the cross aisle between them, to the east.")
    for key in ("south", "north"):
        world.road([west[key], *(f"{aisle}_{key}_e" for aisle in _GOODS), east[key]], 2.0)
        world.road([east[key], *(f"{aisle}_{key}_w" for aisle in reversed(_GOODS)), west[key]], 2.0)
    world.road([west["cross"], *(f"{aisle}_cross" for aisle in _GOODS), east["cross"]], 1.5)


def _dock_road(world: _World, side: str, kind: str, x: float, outward: float) -> dict[str, str]:
    """Add a dock road with docks and bays; return where the main aisles meet it."""
    world.chapter(f"The dock road in the {side}, with the {kind} docks outside and parking bays inside.")
    numbers = count(1)
    stops = {"south": _SOUTH, **{str(i): y for i, y in enumerate(_DOCK_STOPS, start=1)}, "north": _NORTH}
    names = {y: world.waypoint(f"{side}_{key}", x, y) for key, y in stops.items()}
    along = [*names.values()] if side == "west" else [*names.values()][::-1]
    world.road(along, 1.5)
    for dock, y in enumerate(_DOCK_STOPS[::2], start=1):
        # Who leaves a dock does so past where others may wait for it.
        after = along[along.index(names[y]) + 1]
        world.road([names[y], world.waypoint(f"{kind}_{dock}", x + outward, y), after], 0.5)
        world.places.append(f"  {kind}_{dock}: {{at: [{x + outward:g}, {y:g}]}}")
    for y in _DOCK_STOPS:
        if y != _CROSS:
            world.bays.append(_Bay(f"{side}_bay_{next(numbers)}", _FACING_WEST if side == "west" else _FACING_EAST))
            world.driveway(names[y], world.waypoint(world.bays[-1].name, x - outward, y))
    return {"south": names[_SOUTH], "cross": names[_CROSS], "north": names[_NORTH]}


def _lay_out_parking(world: _World) -> None:
    """Add the parking streets; the northernmost bays of all but the last are chargers."""
    bays = chargers = 0
    for aisle in _GOODS:
        world.chapter(f"The parking street {aisle}, to the {'north' if _northward(aisle) else 'south'}.")
        x = _x(aisle)
        street = [world.waypoint(f"street_{aisle}_{row}", x, y) for row, y in enumerate(_PARKING, start=1)]
        names = [f"{aisle}_north_w", *street, world.waypoint(f"{aisle}_top", x, _TOP)]
        world.road(names if _northward(aisle) else names[::-1], 1.0)
        for (stop, y), side in product(zip(street, _PARKING, strict=True), (-1.3, 1.3)):
            if y == _PARKING[-1] and x < _x("m"):
                chargers += 1
                name = f"charger_{chargers:02}"
                world.docks.append(f"  {name}: {{at: [{x + side:g}, {y:g}], type: charger}}")
            else:
                bays += 1
                name = f"bay_{bays:02}"
                world.bays.append(_Bay(name, _FACING_EAST if side < 0 else _FACING_WEST))
            world.driveway(stop, world.waypoint(name, x + side, y))
    world.lanes.append("  # The ends of the streets: up the one, down the other.")
    aisles = [*_GOODS]
    for up in aisles[::2]:
        down = "l" if up == "m" else aisles[aisles.index(up) + 1]
        world.road([f"{up}_top", f"{down}_top"], 1.0)


def _build(world: _World) -> None:
    """Add walls, racks and packing tables."""
    world.walls.append("  # The building, with gates at the docks.")
    south, north = 1.0, 51.5
    world.wall((1, south), (79, south))
    world.wall((1, north), (79, north))
    edges = [south, *(y + side for y in _DOCK_STOPS[::2] for side in (-_GATE, _GATE)), north]
    for x, (y0, y1) in product((1, 79), zip(edges[::2], edges[1::2], strict=True)):
        world.wall((x, y0), (x, y1))
    world.walls.append("  # Racks.")
    for (y0, y1), x in product(_RACKS, range(14, 67, 4)):
        world.solid(x - 0.8, y0, x + 0.8, y1)
    world.walls.append("  # Packing tables.")
    for aisle in [*_GOODS][:-1:2]:
        world.solid(_x(aisle) - 1.5, 3.8, _x(aisle) + 1.5, 4.8)


# --- goods and robots -----------------------------------------------------------------------------------------------


def _stock(world: _World) -> None:
    for aisle, (good, weight) in _GOODS.items():
        world.items.append(f"  # Aisle {aisle}.")
        for number, y in enumerate(_SHELVES, start=1):
            x = _x(aisle) + (1.2 if number % 2 else -1.2)
            world.items.append(f"  {good}_{number}: {{at: [{x:g}, {y:g}], weight: {weight:g}}}")
    world.items.append("  # At the inbound docks.")
    for number, dock in _inbound_pallets():
        y = _DOCK_STOPS[2 * (dock - 1)] + (0.5 if number > len(_DOCK_STOPS[::2]) else -0.5)
        world.items.append(f"  pallet_{number}: {{at: [1.8, {y:g}], weight: {200 + 50 * number}}}")


def _inbound_pallets() -> Iterator[tuple[int, int]]:
    """Yield the number of each pallet and that of its dock."""
    docks = len(_DOCK_STOPS[::2])
    for i in range(10):
        yield i + 1, i % docks + 1


def _man(world: _World) -> None:
    """Add the robots, each in a bay and with its orders."""
    bays = iter(world.bays)
    fleet = {
        "forklift": [_put_away(number, dock) for number, dock in _inbound_pallets()],
        "tug": [_tow(i) for i in range(10)],
        "picker": [*_fetch(36, 1.0, 5.0)],
        "shuttle": [*_fetch(16, 0.0, 1.0)],
        "lifter": [*_fetch(14, 5.0, math.inf)],
        "parcel_cart": [_ship(i) for i in range(8)],
        "inspector": [_inspect(i) for i in range(6)],
    }
    for kind, scripts in fleet.items():
        for number, script in enumerate(scripts, start=1):
            bay = next(bays)
            # Counting takes so long that a battery is nearly empty then.
            home = f"Dock charger_{number:02}" if kind == "inspector" else f"Go {bay.name}"
            orders = ", ".join([*script, home])
            yaw = f", yaw: {bay.yaw:g}" if bay.yaw else ""
            line = f"{kind}_{number:02}: {{type: {kind}, at: {bay.name}{yaw}, script: [{orders}]}}"
            world.robots += _wrapped(line)


def _wrapped(line: str) -> list[str]:
    """Return an entry in lines of a readable length, broken after commas."""
    glued = line.replace(" ", "\0").replace(",\0", ", ")
    lines = textwrap.wrap(glued, 120, initial_indent="  ", subsequent_indent="    ", break_on_hyphens=False)
    return [part.replace("\0", " ") for part in lines]


def _fetch(robots: int, above: float, most: float) -> Iterator[list[str]]:
    """Yield for each robot the orders to bring goods of a range of weights to a packing station."""
    goods = [(number, aisle) for number in range(1, len(_SHELVES) + 1) for aisle in _GOODS]
    fitting = [(number, aisle) for number, aisle in goods if above < _GOODS[aisle][1] <= most]
    for i, (number, aisle) in enumerate(fitting[:robots]):
        item = f"{_GOODS[aisle][0]}_{number}"
        # Orders come in all the time.
        start = [f"Wait {_RUSH * i // robots}"] if i else []
        yield [*start, f"Go {aisle}_{number}", f"Grab {item}", f"Go pack_{i % 6 + 1}", f"Drop {item}"]


def _put_away(pallet: int, dock: int) -> list[str]:
    """Return the orders to bring a pallet from its dock to a rack."""
    start = [f"Wait {150 * (pallet - 1)}"] if pallet > 1 else []
    rack = f"{[*_GOODS][pallet]}_{pallet % len(_SHELVES) + 1}"
    return [*start, f"Go inbound_{dock}", f"Grab pallet_{pallet}", f"Go {rack}", f"Drop pallet_{pallet}"]


def _tow(i: int) -> list[str]:
    """Return the orders to tow trolleys from inbound to outbound docks, four times."""
    tour = [f"Go inbound_{i % 6 + 1}", "Wait 30", f"Go outbound_{6 - i % 6}", "Wait 30"]
    return [f"Wait {30 * i + 5}", *tour * 4]


def _ship(i: int) -> list[str]:
    """Return the orders to bring parcels from a packing station to an outbound dock, six times."""
    tour = [f"Go pack_{i % 6 + 1}", "Wait 20", f"Go outbound_{i % 6 + 1}", "Wait 15"]
    return [f"Wait {20 * i + 60}", *tour * 6]


def _inspect(i: int) -> list[str]:
    """Return the orders to count the shelves of an aisle, in the order in which it is driven."""
    aisle = [*_GOODS][2 * i + 1]
    numbers = range(1, len(_SHELVES) + 1)
    counts = [order for number in reversed(numbers) for order in (f"Go {aisle}_{number}", "Wait 10")]
    return [f"Wait {250 * i + 100}", *counts]


if __name__ == "__main__":
    FILE.write_text(generate(), encoding="utf-8")
