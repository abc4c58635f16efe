"""Pictures of worlds as SVG, in the colours that everything of ours that draws has in common."""

from __future__ import annotations

from hmrsim.drawing.drawing import Drawing
from hmrsim.drawing.frame import extent
from hmrsim.drawing.overlay import Overlay, Weak
from hmrsim.drawing.palette import PALETTE, THEMES, type_colours

__all__ = ["PALETTE", "THEMES", "Drawing", "Overlay", "Weak", "extent", "type_colours"]
