"""Pictures of worlds as SVG, and the palette that the page, reports and recordings share with them.

`hmrsim map render` and reports draw with it.
"""

from __future__ import annotations

from hmrsim.drawing.canvas import PALETTE, THEMES, extent, type_looks
from hmrsim.drawing.drawing import Drawing
from hmrsim.drawing.marks import Overlay, Weak

__all__ = ["PALETTE", "THEMES", "Drawing", "Overlay", "Weak", "extent", "type_looks"]
