"""Trees as pictures: in Graphviz's language, with py_trees' shapes and colors, and as SVG."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from py_trees.common import Status

from hmrsim_zenoh.errors import BadOptions

if TYPE_CHECKING:
    from bt_controller.running.snapshot import Node

_SHAPES: Final = {
    "{-}": ("box", "orange"),
    "[-]": ("box", "orange"),
    "{o}": ("octagon", "cyan"),
    "[o]": ("octagon", "cyan"),
    "/_/": ("parallelogram", "gold"),
    "-^-": ("ellipse", "ghostwhite"),
    "{*}": ("hexagon", "lightsteelblue"),
    "-->": ("ellipse", "gray"),
}
_CONTROLS: Final = ("box", "octagon", "parallelogram", "hexagon")
"""The shapes of controls, whose labels contain the symbol."""

_COLOURS: Final = {Status.SUCCESS: "green3", Status.FAILURE: "red", Status.RUNNING: "blue", Status.INVALID: "gray70"}

_MAX_LETTERS: Final = 60
"""The largest number of characters of a message in a picture."""


def dot(trees: Mapping[str, Sequence[Node]], *, statuses: bool = False) -> str:
    """Return trees, by their titles, as a graph; with *statuses*, border colors and feedback messages are shown."""
    lines = [
        "digraph {",
        "  ordering=out;",
        '  node [style=filled, fontname="times-roman", fontsize=9];',
    ]
    number = 0
    for order, (title, nodes) in enumerate(trees.items()):
        lines += [f"  subgraph cluster_{order} {{", f"    label={_quoted(title)};", "    color=white;"]
        lines += [f"    {line}" for line in _graph(nodes, number, statuses=statuses)]
        lines.append("  }")
        number += len(nodes)
    return "\n".join([*lines, "}", ""])


def svg(graph: str) -> str:
    """Return a graph, as `dot` made it, as SVG.

    Raises:
        BadOptions: Graphviz is not installed.
    """
    command = [check_graphviz(), "-Tsvg"]
    drawn = subprocess.run(command, input=graph, capture_output=True, encoding="utf-8", check=True)  # noqa: S603
    return drawn.stdout


def check_graphviz() -> str:
    """Return the path of Graphviz's program.

    Raises:
        BadOptions: It is not installed.
    """
    if (program := shutil.which("dot")) is None:
        raise BadOptions("--svg needs Graphviz's `dot`, which is not installed; apt install graphviz, or use --dot")
    return program


def _graph(nodes: Sequence[Node], first: int, *, statuses: bool) -> Iterator[str]:
    above: list[int] = []
    for number, node in enumerate(nodes, first):
        shape, color = _SHAPES[node.symbol]
        look = f"shape={shape}, fillcolor={color}"
        label = f"{node.symbol} {node.name}" if shape in _CONTROLS else node.name
        if statuses:
            look += f", color={_COLOURS[node.status]}, penwidth=3"
            label += f"\n{node.message[:_MAX_LETTERS]}" if node.message else ""
        yield f"n{number} [label={_quoted(label)}, {look}];"
        del above[node.depth :]
        if above:
            yield f"n{above[-1]} -> n{number};"
        above.append(number)


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
