"""The page's model of what there is, in the browser that has to run it."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.browser

_CHECKS = Path(__file__).with_name("model_checks.js").read_text("utf-8")


def test_the_model_holds_what_it_claims(viewed, open_page):
    """What is told of worlds, scenes, events and recordings is what the page knows afterwards."""
    _, url = viewed("scenario1")

    checked = open_page(url).evaluate(_CHECKS, "")

    assert {} == checked["wrong"]
    assert checked["claims"] >= 41
