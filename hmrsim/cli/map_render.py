"""``hmrsim map render``: a picture of a world."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.options import add_world_options
from hmrsim.cli.output import check_target, show, write_whole
from hmrsim.cli.worlds import read_world, show_warnings
from hmrsim.drawing import THEMES, Drawing
from hmrsim.program.command_line import ENVIRONMENT
from hmrsim.program.outputs import check_outputs

_EXAMPLES: Final = f"""\
OUT's suffix chooses the format: .svg, or .png, which needs the extra `png` (pip install 'hmrsim[png]'). Without -o the
picture is SVG on stdout. Names are omitted where there is no room for them; a viewer shows them, and more, as
tooltips. The same world gives the same SVG, byte for byte.

examples:
  hmrsim map render hospital -o hospital.svg
  hmrsim map render warehouse -o warehouse.png --theme dark --width 1600
  hmrsim map render office.building.yaml --page L1 --details > office.svg
  hmrsim map render warehouse --bottlenecks -o traffic.svg
  hmrsim map render arena.map --robot wall_e@3,4 --no-legend -o arena.svg

{ENVIRONMENT}"""

_STDOUT: Final = "-"
_MIN_WIDTH, _MAX_WIDTH = 100, 20_000
_SHARPEST: Final = 8.0
_MAX_PIXELS: Final = 200e6


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map render``."""
    parser.description = "Draw a world: walls and lanes, places and docks, robots and items as they are at the start."
    parser.epilog = _EXAMPLES
    add_world_options(parser)
    parser.add_argument("-o", "--output", default=_STDOUT, metavar="OUT", help="the file to write (SVG on stdout)")
    parser.add_argument("--theme", choices=THEMES, default="light", help="colours (light)")
    parser.add_argument("--width", type=_width, default=1200, metavar="N", help="width in pixels (1200)")
    parser.add_argument(
        "--scale",
        type=_scale,
        default=2.0,
        metavar="N",
        help="pixels of a PNG per pixel of the drawing, in each direction (2)",
    )
    parser.add_argument("--no-names", action="store_true", help="write no names")
    parser.add_argument(
        "--no-legend", action="store_true", help="draw the map only, without title, scale bar and legend"
    )
    parser.add_argument("--details", action="store_true", help="write speed limits and capacities beside lanes")
    parser.add_argument(
        "--bottlenecks",
        action="store_true",
        help="draw where traffic concentrates, and the waypoints, lanes and lifts that alone connect parts",
    )
    parser.set_defaults(function=_render)


def _width(text: str) -> int:
    if not text.isdecimal() or not _MIN_WIDTH <= int(text) <= _MAX_WIDTH:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {_MIN_WIDTH} to {_MAX_WIDTH}")
    return int(text)


def _scale(text: str) -> float:
    try:
        scale = float(text)
    except ValueError:
        scale = 0.0
    if not 0.0 < scale <= _SHARPEST:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0, up to {_SHARPEST:g}")
    return scale


def _render(args: argparse.Namespace) -> int:
    out, to = Path(args.output), _format(args.output)
    if args.output != _STDOUT:
        check_target(out, force=True)
    loaded = read_world(args)
    check_outputs([("-o", args.output)], loaded.files)
    show_warnings(loaded)
    overlay = None
    if args.bottlenecks:
        # Imports networkx, which takes longer than drawing most worlds.
        from hmrsim.cli.map_overlay import overlay_of

        overlay = overlay_of(loaded.world, args.theme)
    drawing = Drawing(
        loaded.world,
        args.theme,
        width=args.width,
        names=not args.no_names,
        legend=not args.no_legend,
        details=args.details,
        overlay=overlay,
    )
    svg = drawing.svg()
    if args.output == _STDOUT:
        show(svg)
        return ExitCode.DONE
    write_whole(out, _png(svg, drawing, args.scale) if to == "png" else f"{svg}\n".encode())
    return ExitCode.DONE


def _format(out: str) -> str:
    """Return the format of a file, by its name."""
    suffix = Path(out).suffix.lower()
    if out != _STDOUT and suffix not in (".svg", ".png"):
        raise WrongUse(f"{out}: unknown picture format; expected one of .svg, .png")
    return suffix.removeprefix(".")


def _png(svg: str, drawing: Drawing, scale: float) -> bytes:
    """Return a picture as pixels.

    Raises:
        WrongUse: They are too many, or the package that renders them is not installed.
    """
    width, height = drawing.size
    if width * height * scale * scale > _MAX_PIXELS:
        raise WrongUse(
            f"a PNG of {width * scale:.0f} x {height * scale:.0f} pixels is too large; give less --width or --scale"
        )
    try:
        from resvg_py import svg_to_bytes
    except ImportError:
        raise WrongUse("a PNG needs a package that is not installed; pip install 'hmrsim[png]', or draw .svg") from None
    return bytes(svg_to_bytes(svg_string=svg, zoom=scale))
