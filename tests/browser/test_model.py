"""The page's model of what there is, in the browser that has to run it."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.browser

_HERE = Path(__file__).parent


@pytest.mark.parametrize(("checks", "least"), [("model_checks.js", 41), ("source_checks.js", 9)])
def test_the_model_holds_what_it_claims(viewed, open_page, checks, least):
    """What is told of worlds, scenes, events and recordings is what the page knows afterwards."""
    _, url = viewed("scenario1")

    checked = open_page(url).evaluate((_HERE / checks).read_text("utf-8"), "")

    assert {} == checked["wrong"]
    assert checked["claims"] >= least
