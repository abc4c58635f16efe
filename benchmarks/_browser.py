"""A browser without a screen, which draws by software, before a page of ours."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from benchmarks._processes import PATIENCE

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NAMES = ("chromium", "chromium-browser", "google-chrome")
"""What it may be called, the better ones first."""

_ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--force-color-profile=srgb",
    "--font-render-hinting=none",
    "--disable-features=LocalNetworkAccessChecks",  # or the browser refuses what our server has to
)
_UNTIL = """([condition, seconds, arg]) => new Promise((then, give) => {
  const end = performance.now() + seconds * 1000;
  const look = () => {
    let held = false;
    try {
      held = (CONDITION)(arg);
    } catch (error) {
      if (!(error instanceof TypeError || error instanceof ReferenceError)) give(error);
    }
    if (held) then();
    else if (performance.now() > end) give(new Error(`not after ${seconds} s: ${condition}`));
    else setTimeout(look, 20);
  };
  look();
})"""


@contextmanager
def browser() -> Iterator[Browser]:
    """Start a browser.

    Raises:
        RuntimeError: None is installed.
    """
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - tests are skipped without it

    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        raise RuntimeError(f"no browser; install one of {', '.join(NAMES)}")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=found, args=_ARGUMENTS)
        yield started
        started.close()


def until(page: Page, condition: str, arg: Any = None, *, seconds: float = PATIENCE) -> None:
    """Return when a condition holds on a page.

    Playwright's own `wait_for_function` evaluates texts on the page, which the page's policy rightly forbids.

    Args:
        page: The page.
        condition: In JavaScript; of *arg* if it is a function, as in ``(name) => hmrsim.model.robots.has(name)``.
        arg: The function's argument, as JSON values.
        seconds: Wall seconds after which that is an error.
    """
    function = condition if condition.startswith("(") else f"() => {condition}"
    page.evaluate(_UNTIL.replace("CONDITION", function), [condition, seconds, arg])


def shown(page: Page, url: str) -> Page:
    """Open a view server's page, and return it when its world is there."""
    page.goto(url)
    until(page, "document.documentElement.dataset.ready === 'true'")
    return page
