"""Makes the pictures of the documentation: real screens, photographed while something runs.

``python -m tools.pictures`` makes them all, ``python -m tools.pictures page_dark map`` some. Needs tmux for ``demo``,
Chromium for pages, pngquant, and for ``film`` ImageMagick and gifsicle.
"""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.text import Text

from benchmarks._browser import browser, shown, until
from benchmarks._fleet import grid_world
from benchmarks._processes import HMRSIM, command, free_port, line_of
from benchmarks._wire import served
from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.failure_page import failure_page, run_logged
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.run import VERDICTS
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.settings.run import RunSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from playwright.sync_api import Browser, Page, ViewportSize

WIDTH, HEIGHT = 84, 30
IMAGES = Path(__file__).parents[1] / "docs" / "images"
_MISSION: Final = (sys.executable, "-m", "bt_controller", "run")
_LARGE: Final[ViewportSize] = {"width": 1440, "height": 900}
_SMALL: Final[ViewportSize] = {"width": 1120, "height": 640}
_PHONE: Final[ViewportSize] = {"width": 390, "height": 844}
_DRAWN: Final = "() => new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)))"
"""A promise that is kept when the page has drawn what it knows."""
_FAILS: Final = {
    "world": "hospital",
    "controller": {"tree": "bt_controller.examples.hospital:mission"},
    "properties": {"built_in": {"recovers": {"within": 30}}},
}
"""A check of a mission that gives up when a goal is aborted."""
_FILMED: Final = (30, 150)
"""The frames of the film, half a simulated second each."""


# --- a terminal --------------------------------------------------------------------------------------------------


def demo() -> None:
    """Run the demo in a terminal, and write docs/images/demo.svg when a robot has delivered something."""
    program = Path(sys.executable).with_name("hmrsim")
    tmux = ["tmux", "-L", "hmrsim-pictures"]
    subprocess.run(
        [*tmux, "new-session", "-d", "-x", str(WIDTH), "-y", str(HEIGHT), f"{program} demo; sleep 60"], check=True
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
    # The fonts that rich names are on another host; each viewer has its own.
    picture = re.sub(r"@font-face \{.*?\}\s*", "", picture, flags=re.DOTALL)
    (IMAGES / "demo.svg").write_text(picture, encoding="utf-8")


# --- worlds and reports ------------------------------------------------------------------------------------------


def world() -> None:
    """Draw the hospital, and its bottlenecks."""
    subprocess.run([*HMRSIM, "map", "render", "hospital", "-o", str(IMAGES / "map.svg")], check=True)
    subprocess.run(
        [*HMRSIM, "map", "render", "hospital", "--bottlenecks", "-o", str(IMAGES / "bottlenecks.svg")], check=True
    )


def report() -> None:
    """Report on half an hour of the warehouse, and photograph the report."""
    with tempfile.TemporaryDirectory() as folder, browser() as chromium:
        trace, page = Path(folder, "run.jsonl"), Path(folder, "report.html")
        run = ["simulate", "warehouse", "--duration", "1800", "--trace", str(trace)]
        # It ends with 1, as it is not done by then.
        subprocess.run([*HMRSIM, *run], check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        subprocess.run([*HMRSIM, "report", str(trace), "-o", str(page)], check=True)
        tab = _large(chromium)
        tab.goto(page.as_uri())
        _photograph(tab, "report")


def failure() -> None:
    """Photograph the page of a mission that fails when a robot can't put something down."""
    check = check_at(CheckFile.model_validate(_FAILS), Path.cwd())
    case = Case((Injection({"type": "goals_aborted", "robot": "burn_e", "action": "place", "count": 1, "at": 0.0}),))
    with tempfile.TemporaryDirectory() as folder, browser() as chromium:
        page = Path(folder, "failure.html")
        page.write_text(failure_page(check, case, *run_logged(check, case, VERDICTS)), encoding="utf-8")
        tab = chromium.new_page(viewport={"width": 1440, "height": 1100})
        tab.goto(page.as_uri())
        _photograph(tab, "failure")


# --- the page ----------------------------------------------------------------------------------------------------


def _photograph(page: Page, name: str) -> None:
    """Write docs/images/NAME.png with a palette, which makes flat pictures three times smaller."""
    page.evaluate(_DRAWN)
    path = IMAGES / f"{name}.png"
    page.screenshot(path=path)
    subprocess.run(["pngquant", "--force", "--ext", ".png", "--nofs", str(path)], check=True)


@contextmanager
def _hospital(factor: float = 4.0) -> Iterator[str]:
    """Run the mission in the hospital; yields where its page is."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    run = ("run", "hospital", "--listen", endpoint, "--real-time-factor", str(factor), "--json")
    robots = ("--robot", "wall_e", "eve", "burn_e", "m_o", "nan_e", "d_fib", "auto", "vaq_m")
    with ExitStack() as stack:
        simulator = stack.enter_context(command(*HMRSIM, *run))
        line_of(simulator)
        view = stack.enter_context(command(*HMRSIM, "view", "--connect", endpoint, "--port", "0", "--json"))
        url = json.loads(line_of(view))["url"]
        stack.enter_context(
            command(*_MISSION, "bt_controller.examples.hospital:mission", *robots, "--connect", endpoint, "--quiet")
        )
        yield url


def _large(chromium: Browser) -> Page:
    return chromium.new_page(viewport=_LARGE)


def _small(chromium: Browser) -> Page:
    return chromium.new_page(viewport=_SMALL)


def _phone(chromium: Browser) -> Page:
    return chromium.new_page(viewport=_PHONE, device_scale_factor=2, is_mobile=True, has_touch=True)


def _page(name: str, at: float, tab: Callable[[Browser], Page], query: str) -> None:
    """Photograph the hospital at a simulated time, standing still."""
    with _hospital() as url, browser() as chromium:
        page = shown(tab(chromium), f"{url}?{query}")
        until(page, "(at) => hmrsim.clock.now() >= at", at)
        page.get_by_role("button", name="Got it").click()
        page.evaluate("hmrsim.commands.pause()")
        until(page, "hmrsim.clock.paused")
        _photograph(page, name)


def film() -> None:
    """Film the hospital as docs/images/page.gif, frame by frame from a recording, five times as fast as it is."""
    robots = ("wall_e", "eve", "burn_e", "m_o", "nan_e", "d_fib", "auto", "vaq_m")
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with tempfile.TemporaryDirectory() as folder, browser() as chromium:
        recording = Path(folder, "run.mcap")
        run = ("run", "hospital", "--listen", endpoint, "--clock", "lockstep", "--json")
        mission = ("bt_controller.examples.hospital:mission", "--robot", *robots, "--connect", endpoint, "--quiet")
        with command(*HMRSIM, *run, "--duration", str(_FILMED[1]), "--record", str(recording)) as simulator:
            line_of(simulator)
            with command(*_MISSION, *mission):
                simulator.wait(timeout=60)
        with command(*HMRSIM, "view", str(recording), "--port", "0", "--json") as view:
            page = shown(_small(chromium), f"{json.loads(line_of(view))['url']}?theme=light&panel=goals")
            page.evaluate("hmrsim.playback.pause()")
            for number, at in enumerate(range(*_FILMED)):
                page.evaluate("(at) => hmrsim.playback.seek(hmrsim.playback.begin + at)", at / 2)
                page.evaluate(_DRAWN)
                page.screenshot(path=Path(folder, f"{number:03d}.png"))
        frames = [str(path) for path in sorted(Path(folder).glob("*.png"))]
        palette, whole = str(Path(folder, "palette.gif")), str(Path(folder, "whole.gif"))
        subprocess.run(
            ["convert", *frames[::20], "-append", "+dither", "-colors", "128", "-unique-colors", palette], check=True
        )
        subprocess.run(
            ["convert", "-delay", "10", "-loop", "0", *frames, "+dither", "-remap", palette, whole], check=True
        )
        subprocess.run(["gifsicle", "-O3", "--lossy=8", whole, "-o", str(IMAGES / "page.gif")], check=True)


def thousand() -> None:
    """Photograph a thousand robots on their ways."""
    settings = RunSettings(keep_results=10)
    with (
        served(grid_world(1000), settings, wandering=1000) as grid,
        command(*HMRSIM, "view", "--connect", grid.endpoint, "--port", "0", "--json") as view,
        browser() as chromium,
    ):
        url = json.loads(line_of(view))["url"]
        page = shown(_large(chromium), f"{url}?theme=dark&panel=none")
        until(page, "hmrsim.map.stats.frames > 60")
        page.get_by_role("button", name="Got it").click()
        _photograph(page, "thousand")


PICTURES: Final[Mapping[str, Callable[[], None]]] = {
    "demo": demo,
    "map": world,
    "page_light": partial(_page, "page_light", 60.0, _large, "theme=light&panel=goals"),
    "page_dark": partial(_page, "page_dark", 60.0, _large, "theme=dark&panel=trees&follow=wall_e"),
    "page_phone": partial(_page, "page_phone", 60.0, _phone, "theme=dark"),
    "film": film,
    "thousand": thousand,
    "report": report,
    "failure": failure,
}


def main() -> None:
    """Make the pictures that are named, or all."""
    wanted = sys.argv[1:] or list(PICTURES)
    for unknown in set(wanted) - PICTURES.keys():
        sys.exit(f"no picture {unknown!r}; there are {', '.join(PICTURES)}")
    for name in wanted:
        PICTURES[name]()


if __name__ == "__main__":
    main()
