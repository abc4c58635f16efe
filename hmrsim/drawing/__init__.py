"""Pictures of worlds as SVG, and the palette that the page, reports and recordings share with them.

`hmrsim map render` and reports draw with it.
"""

from __future__ import annotations

from hmrsim.drawing.drawing import Drawing
from hmrsim.drawing.frame import extent
from hmrsim.drawing.overlay import Overlay, Weak
from hmrsim.drawing.palette import PALETTE, THEMES, type_looks

__all__ = ["PALETTE", "THEMES", "Drawing", "Overlay", "Weak", "extent", "type_looks"]
