"""Small draw.io files, made in tests."""

from __future__ import annotations

import base64
import zlib
from html import escape
from urllib.parse import quote

WALL = "shape=mxgraph.floorplan.wall"
WALL_U = "shape=mxgraph.floorplan.wallU"
CORNER = "shape=mxgraph.floorplan.wallCorner"
ROOM = "shape=mxgraph.floorplan.room"


def model(*cells: str, attributes: str = "") -> str:
    return (
        f'<mxGraphModel pageWidth="600" pageHeight="400" {attributes}><root>'
        f'<mxCell id="0"/><mxCell id="1" parent="0"/>{"".join(cells)}</root></mxGraphModel>'
    )


def file(*diagrams: str) -> str:
    return f'<mxfile host="test">{"".join(diagrams)}</mxfile>'


def diagram(content: str, name: str = "test") -> str:
    return f'<diagram name="{name}">{content}</diagram>'


def drawing(*cells: str) -> str:
    return file(diagram(model(*cells)))


def packed(content: str | bytes) -> str:
    deflater = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = content if isinstance(content, bytes) else quote(content, safe="~()*!.'").encode()
    return base64.b64encode(deflater.compress(data) + deflater.flush()).decode()


def shape(style: str, x: float, y: float, width: float, height: float, **more: str) -> str:
    extra = _attributes({"id": f"s{x:g}-{y:g}", "parent": "1", **more})
    return f'<mxCell style="{style}" vertex="1"{extra}>{_box(x, y, width, height)}</mxCell>'


def typed(
    kind: str, x: float, y: float, width: float = 30, height: float = 30, *, parent: str = "1", **attributes: str
) -> str:
    extra = _attributes({"label": "", "type": kind, "id": f"{kind}{x:g}-{y:g}", **attributes})
    return (
        f'<object{extra}><mxCell style="ellipse" parent="{parent}" vertex="1">'
        f"{_box(x, y, width, height)}</mxCell></object>"
    )


def robot(name: str = "eve", **attributes: str) -> str:
    return typed("robot", 85, 85, name=name, **{"id": name, **attributes})


def line(
    kind: str, *points: tuple[float, float], source: str = "", target: str = "", parent: str = "1", identifier: str = ""
) -> str:
    first, *rest, last = (f'<mxPoint x="{x}" y="{y}"%s/>' for x, y in points)
    ends = _attributes({key: value for key, value in (("source", source), ("target", target)) if value})
    return (
        f'<object label="" type="{kind}" id="{identifier or kind + repr(hash(points))}">'
        f'<mxCell style="html=1" parent="{parent}" edge="1"{ends}><mxGeometry relative="1" as="geometry">'
        + first % ' as="sourcePoint"'
        + last % ' as="targetPoint"'
        + f'<Array as="points">{"".join(point % "" for point in rest)}</Array>'
        + "</mxGeometry></mxCell></object>"
    )


def road(*points: tuple[float, float], **more: str) -> str:
    return line("map-path", *points, **more)


def _attributes(values: dict[str, str]) -> str:
    return "".join(f' {key}="{escape(value)}"' for key, value in values.items())


def _box(x: float, y: float, width: float, height: float) -> str:
    return f'<mxGeometry x="{x}" y="{y}" width="{width}" height="{height}" as="geometry"/>'
