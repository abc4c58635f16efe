"""Small draw.io files, made in tests."""

from __future__ import annotations

import base64
import zlib
from urllib.parse import quote


def drawing(cells: str, *, attributes: str = "") -> str:
    """Return a plain file with these cells."""
    return (
        f'<mxfile><diagram name="test"><mxGraphModel pageWidth="600" pageHeight="400" {attributes}><root>'
        f'<mxCell id="0"/><mxCell id="1" parent="0"/>{cells}</root></mxGraphModel></diagram></mxfile>'
    )


def pack(model: str) -> str:
    """Return an ``mxGraphModel`` as draw.io compresses it."""
    return packed_bytes(quote(model, safe="").encode())


def packed_bytes(content: bytes) -> str:
    """Return a file whose compressed diagram is *content*."""
    deflater = zlib.compressobj(9, zlib.DEFLATED, -15)
    text = base64.b64encode(deflater.compress(content) + deflater.flush()).decode()
    return f'<mxfile><diagram name="Ward">{text}</diagram></mxfile>'


def shape(style: str, x: float, y: float, width: float, height: float, **more: str) -> str:
    """Return an untyped cell."""
    extra = "".join(f' {key}="{value}"' for key, value in {"id": "s", "parent": "1", **more}.items())
    return (
        f'<mxCell style="{style}" vertex="1"{extra}>'
        f'<mxGeometry x="{x}" y="{y}" width="{width}" height="{height}" as="geometry"/></mxCell>'
    )


def typed(kind: str, x: float, y: float, width: float, height: float, **attributes: str) -> str:
    """Return a typed object."""
    extra = "".join(f' {key}="{value}"' for key, value in {"id": f"{kind}{x:g}-{y:g}", **attributes}.items())
    return (
        f'<object label="" type="{kind}"{extra}><mxCell style="ellipse" parent="1" vertex="1">'
        f'<mxGeometry x="{x}" y="{y}" width="{width}" height="{height}" as="geometry"/></mxCell></object>'
    )


def road(*points: tuple[float, float], identifier: str = "", ends: str = "") -> str:
    """Return a road along these points."""
    first, *rest, last = (f'<mxPoint x="{x}" y="{y}"%s/>' for x, y in points)
    return (
        f'<object label="" type="map-path" id="{identifier or hash(points)}">'
        f'<mxCell style="html=1" parent="1" edge="1" {ends}><mxGeometry relative="1" as="geometry">'
        + first % ' as="sourcePoint"'
        + last % ' as="targetPoint"'
        + f'<Array as="points">{"".join(point % "" for point in rest)}</Array>'
        + "</mxGeometry></mxCell></object>"
    )
