"""The VDMA's Layout Interchange Format (LIF) for VDA 5050: layouts of nodes, directed edges and stations."""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING

from hmrsim.world.formats import Format
from hmrsim.world.formats._lif_things import Layout, Things
from hmrsim.world.formats._pages import choose_page
from hmrsim.world.formats._part import BadPart, Part
from hmrsim.world.formats._reading import of_json
from hmrsim.world.options import AS_IT_IS, ReadOptions

if TYPE_CHECKING:
    from hmrsim.world.formats import Document

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
    things = Things(reading, chosen)
    things.read(layouts)
    return reading.document({"name": name, **things.data} if name else things.data, pages=pages)


def _check_version(about: Part) -> None:
    """Do nothing if the file is of a version that is read here.

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
    """Return a layout; one that is on no level is a level of its own.

    Raises:
        BadPart: It has no id.
    """
    identifier = part.want("layoutId").name()
    name, level = part.get("layoutName"), part.get("layoutLevelId")
    return Layout(name.name() if name and name.value else identifier, level.text() if level else identifier, part)


FORMAT = Format(name="lif", suffixes=(".lif.json",), matches=lambda text: bool(_LOOKS.match(text)), read=_read)
