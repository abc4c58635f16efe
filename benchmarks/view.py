"""The cost of the live view while robots drive: in the page, its server and the simulator."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks._browser import browser, shown
from benchmarks._fleet import SIDE, grid_world
from benchmarks._processes import HMRSIM, command, line_of, processor_seconds
from benchmarks._report import Row
from benchmarks._wire import served
from hmrsim.settings.run import RunSettings

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

QUICK: dict[str, Any] = {"sizes": (10, 100), "window": 2.0}

_SETTLING = 2.0
"""Wall seconds between the page's being there and the measurement."""
_LARGE = 1000
_FRAMES, _LATE, _SCRIPT = 50.0, 40.0, 8.0
_SERVER, _IDLE = 25.0, 0.5
_STATS = "() => [hmrsim.map.stats.frames, hmrsim.map.stats.scriptMs]"
_PANELS = "rgoetc"
"""The keys of the panels."""
_GAPS = """(ms) => new Promise((then) => {
  const [began, drawn, gaps] = [performance.now(), hmrsim.map.stats.frames, []];
  let before = null;
  const look = (at) => {
    if (before !== null) gaps.push(at - before);
    before = at;
    if (performance.now() - began < ms) return requestAnimationFrame(look);
    gaps.sort((a, b) => a - b);
    const frames = ((hmrsim.map.stats.frames - drawn) * 1000) / (performance.now() - began);
    then([frames, gaps[Math.floor(gaps.length * 0.95)]]);
  };
  requestAnimationFrame(look);
})"""
"""Return the drawn frames per second, and the 95th percentile of the milliseconds between frames."""


class _Costs(NamedTuple):
    """Percent of a core that the simulator and the view server take."""

    simulator: float
    server: float


def run(*, sizes: Sequence[int] = (10, 100, 1000), window: float = 10.0, side: int = SIDE) -> list[Row]:
    """Return processor shares at real-time factor 1 with a page and without, and how the page draws."""
    with browser() as chromium:
        return [row for size in sizes for row in _of(chromium, size, window, side)]


def _of(chromium: Browser, robots: int, window: float, side: int) -> list[Row]:
    """Return the rows of one number of robots, all of which drive."""
    with (
        served(grid_world(robots, side=side), RunSettings(keep_results=10), wandering=robots) as world,
        command(*HMRSIM, "view", "--connect", world.endpoint, "--port", "0", "--json") as server,
    ):
        url = json.loads(line_of(server))["url"]
        pids = (world.child.pid, server.pid)
        time.sleep(_SETTLING)
        unseen = _costs(pids, window)
        page = shown(chromium.new_page(viewport={"width": 1280, "height": 800}), url)
        page.wait_for_timeout(_SETTLING * 1000)
        seen, frames, script = _watched(page, pids, window)
        fewest, late = _with_panels(page, window)
        page.close()
    large = robots >= _LARGE
    name = f"{robots:,} robots"
    return [
        Row(f"{name}: simulator, no page", unseen.simulator, "% of a core"),
        Row(f"{name}: simulator, a page", seen.simulator, "% of a core"),
        Row(f"{name}: view server, no page", unseen.server, "% of a core", at_most=_IDLE),
        Row(f"{name}: view server, a page", seen.server, "% of a core", at_most=_SERVER),
        Row(f"{name}: script of a frame", script, "ms", at_most=_SCRIPT if large else None),
        Row(f"{name}: frames", frames, "frames/s", at_least=_FRAMES if large else None),
        Row(f"{name}: frames, worst panel", fewest, "frames/s", at_least=_FRAMES if large else None),
        Row(f"{name}: between frames, worst panel, p95", late, "ms", at_most=_LATE if large else None),
    ]


def _watched(page: Page, pids: Sequence[int], window: float) -> tuple[_Costs, float, float]:
    """Return the costs while a page is looked at, its frames a second, and milliseconds of script a frame."""
    before, began = page.evaluate(_STATS)[0], time.perf_counter()
    costs = _costs(pids, window)
    frames, script = page.evaluate(_STATS)
    return costs, (frames - before) / (time.perf_counter() - began), script


def _with_panels(page: Page, window: float) -> tuple[float, float]:
    """Return the frames a second and the 95th percentile between frames of the worst panel, with a selected robot."""
    page.keyboard.press("n")
    measured = []
    for key in _PANELS:
        page.keyboard.press(key)
        page.wait_for_timeout(_SETTLING * 1000)
        measured.append(page.evaluate(_GAPS, window / len(_PANELS) * 1000))
    return min(frames for frames, _ in measured), max(late for _, late in measured)


def _costs(pids: Sequence[int], window: float) -> _Costs:
    used, began = [processor_seconds(pid) for pid in pids], time.perf_counter()
    time.sleep(window)
    took = time.perf_counter() - began
    return _Costs(*(100 * (processor_seconds(pid) - before) / took for pid, before in zip(pids, used, strict=True)))
