"""The check of the built site."""

from __future__ import annotations

import pytest

from tools.site import Page, fault_of


@pytest.mark.parametrize(
    ("target", "fault"),
    [
        ("there.html", ""),
        ("there.html#place", ""),
        ("#anywhere", ""),
        ("https://zenoh.io", ""),
        ("gone.png", "there is no such file"),
        ("there.html#gone", "there is no such heading"),
        ("ftp://zenoh.io", "expected a path or an address"),
    ],
)
def test_a_link_that_leads_nowhere_is_told(tmp_path, target, fault):
    """Files and headings are looked for; other sites are not asked."""
    there = tmp_path / "there.html"
    there.write_text('<h2 id="place">A place</h2>')

    assert fault == fault_of(target, tmp_path, {there: Page(there)})
