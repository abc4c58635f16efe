"""The buildings of Open-RMF's traffic editor: levels of vertices, and the lanes, walls and doors between them.

Coordinates become meters, y up, as Open-RMF's building_map_tools make them; levels are put side by side.
"""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING

from hmrsim.world.formats import Format
from hmrsim.world.formats._layouts import choose_page, side_by_side
from hmrsim.world.formats._reading import BadPart, Part, Reading, of_yaml
from hmrsim.world.formats._rmf_conversion import Shafts, convert, lifts
from hmrsim.world.formats._rmf_level import Level, by_degrees, by_fiducials, by_scale, read_level
from hmrsim.world.options import AS_IT_IS, ReadOptions

if TYPE_CHECKING:
    from hmrsim.world.formats import Document

_LOOKS = re.compile(r"""^["']?levels["']?[ ]*:""", re.MULTILINE)

_IMAGE, _METRES, _DEGREES = "reference_image", "cartesian_meters", "wgs84"


def _read(text: str, file: str, options: ReadOptions = AS_IT_IS) -> Document:
    reading = of_yaml(text, file)
    root = reading.root
    system = reading.attempt(partial(_system, root)) or _IMAGE
    levels = [
        read_level(reading, name, part, down=system == _IMAGE)
        for name, part in reading.attempt(lambda: list(root.want("levels").entries())) or ()
    ]
    if not levels:
        reading.complain(reading.root, "has no levels")
        return reading.document({})
    reference = reading.attempt(partial(_reference, root, levels)) or levels[0]
    _align(reading, levels, reference, system)
    pages = tuple(level.name for level in levels)
    chosen = levels if options.page is None else [levels[choose_page(pages, options.page, file, noun="level")]]
    for level, shift in zip(chosen, side_by_side([map(level.at, level.vertices) for level in chosen]), strict=True):
        level.shift = shift
    conversion = convert(reading, chosen, options)
    shafts = Shafts({level.name: level for level in levels}, reference, system == _IMAGE)
    data = {"name": _name(root), **conversion.data, "lifts": lifts(reading, shafts)}
    return reading.document(data, pages=pages, robots=tuple(conversion.robots))


def _name(root: Part) -> str:
    name = root.value.get("building_name") or root.value.get("name")
    return str(name)[:100] if name else "building"


def _system(root: Part) -> str:
    """Return the coordinate system.

    Raises:
        BadPart: It is not supported.
    """
    part = root.get("coordinate_system") or Part(_IMAGE)
    if part.value not in (_IMAGE, _METRES, _DEGREES):
        raise part.expected(f"{_IMAGE}, {_METRES} or {_DEGREES}")
    return part.text()


def _align(reading: Reading, levels: list[Level], reference: Level, system: str) -> None:
    """Set the alignment of each level."""
    if system == _IMAGE:
        _align_images(reading, levels, reference)
    elif system == _DEGREES:
        align = by_degrees([vertex.drawn for level in levels for vertex in level.vertices.values()])
        if align is None:
            reading.complain(reading.root.want("levels"), "is not around one place; expected longitudes and latitudes")
        for level in levels:
            level.align = align or level.align


def _align_images(reading: Reading, levels: list[Level], reference: Level) -> None:
    """Scale the reference level by its measurements, and align the others with it by common fiducials."""
    scale = reading.attempt(reference.scale)
    if scale is None:
        reading.warn(reference.part, "has no measurements, so that a pixel of its drawing counts as a meter")
        scale = 1.0
    reference.align = by_scale(scale)
    for level in levels:
        if level is not reference:
            onto = by_fiducials(level.fiducials, reference.fiducials, scale)
            level.align = onto or by_scale(reading.attempt(level.scale) or scale)


def _reference(root: Part, levels: list[Level]) -> Level:
    name = root.get("reference_level_name")
    if name is None or name.value == "":
        return levels[0]
    for level in levels:
        if level.name == name.value:
            return level
    raise BadPart(name, f"no level {name.value!r}; there are {', '.join(level.name for level in levels)}")


FORMAT = Format(
    name="rmf_building", suffixes=(".building.yaml",), matches=lambda text: bool(_LOOKS.search(text)), read=_read
)
