"""The VDMA's Layout Interchange Format (LIF) for VDA 5050: layouts of nodes, directed edges and stations."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.world.files import AS_IT_IS, ReadOptions
from hmrsim.world.formats import Format
from hmrsim.world.formats._layouts import Edges, choose_page, side_by_side
from hmrsim.world.formats._reading import BadPart, Part, of_json
from hmrsim.world.network import connected

if TYPE_CHECKING:
    from hmrsim.world.formats import Document
    from hmrsim.world.formats._reading import Reading

_CHARGING = "startCharging"
"""The VDA 5050 action that the node of a charger offers."""

_OF_NODES = frozenset(("vehicleTypeId", "actions"))
_OF_EDGES = frozenset(("vehicleTypeId", "maxSpeed", "rotationAllowed", "orientationType"))
"""Properties of vehicle types that are read, or that need no translation."""

_UNRESTRICTED: tuple[object, ...] = (None, "", [], {}, "BOTH", 0, True)
"""Values of other properties that restrict no robot."""


@dataclass(frozen=True, eq=False)
class Layout:
    """A layout of a LIF file."""

    name: str
    level: str
    part: Part


@dataclass(frozen=True)
class _Node:
    part: Part
    layout: Layout
    at: complex
    charges: bool


class _Conversion:
    """The conversion of layouts into the keys of a world.

    Attributes:
        data: The keys of a world.
    """

    def __init__(self, reading: Reading, chosen: Sequence[Layout]) -> None:
        self.data: dict[str, Any] = {"waypoints": {}, "places": {}, "docks": {}}
        self._reading = reading
        self._chosen = chosen
        self._nodes: dict[str, _Node] = {}
        self._edges = Edges(reading)
        self._rides: list[tuple[str, str, Part]] = []
        self._stations: set[str] = set()

    def read(self, layouts: Sequence[Layout]) -> None:
        """Read the chosen *layouts*; edges may lead to the others."""
        for layout in layouts:
            for part in self._parts(layout, "nodes"):
                self._reading.attempt(partial(self._node, layout, part))
        self._waypoints()
        for layout in self._chosen:
            for part in self._parts(layout, "edges"):
                self._reading.attempt(partial(self._edge, part))
            for part in self._parts(layout, "stations"):
                self._reading.attempt(partial(self._station, part))
        self.data["lanes"] = self._edges.lanes()
        self.data["lifts"] = self._lifts()

    def _parts(self, layout: Layout, key: str) -> list[Part]:
        return self._reading.attempt(partial(layout.part.parts, key)) or []

    def _keep(self, key: str, name: str, value: object, part: Part) -> None:
        self.data[key][name] = value
        self._reading.origin((key, name), part)

    def _node(self, layout: Layout, part: Part) -> None:
        """Read a node.

        Raises:
            BadPart: It has no id, or that of another, or is nowhere.
        """
        identifier = part.want("nodeId")
        name = identifier.name()
        if name in self._nodes:
            raise BadPart(identifier, f"{name!r} is the id of another node, too; ids are unique in a file")
        position = part.want("nodePosition")
        at = complex(position.want("x").number(), position.want("y").number())
        properties = part.parts("vehicleTypeNodeProperties")
        actions = [action for one in properties for action in one.parts("actions")]
        self._nodes[name] = _Node(part, layout, at, any(_type_of(action) == _CHARGING for action in actions))
        if layout in self._chosen:
            self._leave_out(properties, _OF_NODES)
            for action in actions:
                if _type_of(action) not in (_CHARGING, "stopCharging"):
                    self._reading.leave_out("actions of nodes", action)

    def _waypoints(self) -> None:
        """Place the levels side by side; layouts of the same level keep their positions."""
        nodes = {name: node for name, node in self._nodes.items() if node.layout in self._chosen}
        levels: dict[str, list[complex]] = {layout.level: [] for layout in self._chosen}
        for node in nodes.values():
            levels[node.layout.level].append(node.at)
        shifts = dict(zip(levels, side_by_side([*levels.values()]), strict=True))
        for name, node in nodes.items():
            at = node.at + shifts[node.layout.level]
            self._keep("waypoints", name, [at.real, at.imag], node.part)

    def _edge(self, part: Part) -> None:
        """Read an edge: a lane, or a ride in a lift if it leads to another level.

        Raises:
            BadPart: An end is not a node.
        """
        start, end = (self._known(part.want(key)) for key in ("startNodeId", "endNodeId"))
        properties = part.parts("vehicleTypeEdgeProperties")
        self._leave_out(properties, _OF_EDGES)
        if end not in self.data["waypoints"] or start not in self.data["waypoints"]:
            self._reading.leave_out("edges from or to other layouts", part)
        elif part.get("vehicleTypeEdgeProperties") is not None and not properties:
            self._reading.leave_out("edges that no vehicle type may use", part)
        elif self._nodes[start].layout.level != self._nodes[end].layout.level:
            self._rides.append((start, end, part))
        else:
            self._edges.add((start, end), part, limit=self._limit(properties))

    def _known(self, part: Part) -> str:
        name = part.text()
        if name not in self._nodes:
            raise BadPart(part, f"no node has the id {name[:100]!r}")
        return name

    def _limit(self, properties: list[Part]) -> float | None:
        """Return the speed limit of the fastest vehicle type, or None if there is no limit."""
        speeds = [speed.number() if speed else None for speed in (one.get("maxSpeed") for one in properties)]
        limits = [speed for speed in speeds if speed is not None]
        fastest = max(limits) if limits and len(limits) == len(speeds) else None
        slower = sum(limit != fastest for limit in limits)
        if slower:
            self._reading.leave_out("speed limits of slower vehicle types", properties[0], slower)
        return fastest

    def _leave_out(self, properties: list[Part], known: frozenset[str]) -> None:
        for one in properties:
            for key, value in one.entries():
                if key not in known and value.value not in _UNRESTRICTED:
                    self._reading.leave_out(key, value)

    def _station(self, part: Part) -> None:
        """Read a station as a dock if vehicles can charge there, else as a place; it is at its first node.

        Raises:
            BadPart: It has no id, or that of another, or no node.
        """
        identifier = part.want("stationId")
        name = identifier.name()
        if name in self._stations:
            raise BadPart(identifier, f"{name!r} is the id of another station, too; ids are unique in a file")
        self._stations.add(name)
        nodes = [self._known(node) for node in part.want("interactionNodeIds").all()]
        if not nodes:
            raise BadPart(part.want("interactionNodeIds"), "is empty; name a node where vehicles interact")
        first = next((node for node in nodes if node in self.data["waypoints"]), None)
        if first is None:
            self._reading.leave_out("stations of other layouts", part)
            return
        if len(nodes) > 1:
            self._reading.leave_out("further nodes of stations", part.want("interactionNodeIds"), len(nodes) - 1)
        at = self.data["waypoints"][first]
        if self.data["waypoints"].get(name, at) != at:
            name = f"station {name}"
        if any(self._nodes[node].charges for node in nodes):
            self._keep("docks", name, {"at": at, "type": "charger"}, part)
        else:
            self._keep("places", name, {"at": at}, part)

    def _lifts(self) -> dict[str, Any]:
        """Return the lifts: one for all nodes that edges between levels connect, named after the first edge."""
        shaft = connected((start, end) for start, end, _ in self._rides)
        order = {level: i for i, level in enumerate(dict.fromkeys(layout.level for layout in self._chosen))}
        stops: dict[str, dict[str, str]] = {}
        for node in shaft:
            stops.setdefault(shaft[node], {}).setdefault(self._nodes[node].layout.level, node)
        lifts: dict[str, Any] = {}
        for start, _, part in self._rides:
            if levels := stops.pop(shaft[start], None):
                name = part.value.get("edgeId") or f"lift_{len(lifts) + 1}"
                lifts[str(name)] = {"stops": [levels[level] for level in sorted(levels, key=order.__getitem__)]}
                self._reading.origin(("lifts", str(name)), part)
        return lifts


def _type_of(action: Part) -> str:
    kind = action.get("actionType")
    return kind.text() if kind else ""


_LOOKS = re.compile(r'\A\s*\{.*"(lifVersion|layouts)"\s*:', re.DOTALL)


def _read(text: str, file: str, options: ReadOptions = AS_IT_IS) -> Document:
    reading = of_json(text, file)
    root = reading.root
    about = root.get("metaInformation") or Part({})
    reading.attempt(partial(_check_version, about))
    layouts = [
        layout
        for part in reading.attempt(lambda: root.want("layouts").all()) or ()
        if (layout := reading.attempt(partial(_layout, part)))
    ]
    pages = tuple(layout.name for layout in layouts)
    chosen = layouts
    if options.page is not None and not reading.failed:
        chosen = [layouts[choose_page(pages, options.page, file, noun="layout")]]
    name = reading.attempt(partial(_project, about))
    conversion = _Conversion(reading, chosen)
    conversion.read(layouts)
    return reading.document({"name": name, **conversion.data} if name else conversion.data, pages=pages)


def _check_version(about: Part) -> None:
    """Check that the file has a supported version.

    Raises:
        BadPart: It is not.
    """
    version = about.get("lifVersion")
    if version is not None and version.text().partition(".")[0] not in ("0", "1"):
        raise BadPart(version, f"LIF {version.value} is not read; expected version 1")


def _project(about: Part) -> str:
    name = about.get("projectIdentification")
    return name.text()[:100] if name else ""


def _layout(part: Part) -> Layout:
    """Return a layout; one without a level is its own level.

    Raises:
        BadPart: It has no id.
    """
    identifier = part.want("layoutId").name()
    name, level = part.get("layoutName"), part.get("layoutLevelId")
    return Layout(name.name() if name and name.value else identifier, level.text() if level else identifier, part)


FORMAT = Format(name="lif", suffixes=(".lif.json",), matches=lambda text: bool(_LOOKS.match(text)), read=_read)
