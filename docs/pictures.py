"""Makes the pictures of the documentation: a real terminal, photographed while the demo runs. Needs tmux."""

from __future__ import annotations

import io
import re
import subprocess
import sys
import time
from pathlib import Path

from rich.console import Console
from rich.text import Text

WIDTH, HEIGHT = 84, 30
DOCS = Path(__file__).parent


def main() -> None:
    """Run the demo in a terminal, and write docs/demo.svg when a robot has delivered something."""
    demo = Path(sys.executable).with_name("hmrsim")
    tmux = ["tmux", "-L", "hmrsim-pictures"]
    subprocess.run(
        [*tmux, "new-session", "-d", "-x", str(WIDTH), "-y", str(HEIGHT), f"{demo} demo; sleep 60"], check=True
    )
    try:
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            screen = subprocess.run(
                [*tmux, "capture-pane", "-e", "-p"], check=True, capture_output=True, text=True
            ).stdout
            if "Go to ward_a" in screen and "mission done" in screen:
                break
            time.sleep(0.1)
    finally:
        subprocess.run([*tmux, "kill-server"], check=False)
    console = Console(width=WIDTH, record=True, file=io.StringIO(), force_terminal=True)
    console.print(Text.from_ansi(screen), end="")
    picture = console.export_svg(title="hmrsim demo", unique_id="demo")
    # The fonts that rich names are on another host; whoever looks has one of his own.
    picture = re.sub(r"@font-face \{.*?\}\s*", "", picture, flags=re.DOTALL)
    (DOCS / "demo.svg").write_text(picture, encoding="utf-8")


if __name__ == "__main__":
    main()
