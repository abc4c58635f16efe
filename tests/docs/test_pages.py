"""Each page of the documentation is followed block by block, and shows the real output."""

from __future__ import annotations

import pytest

from tests.docs.page import blocks_of
from tests.docs.session import Session
from tests.paths import ROOT

FILES = ROOT / "tests" / "docs" / "files"
"""What readers of a page have already, in a folder called as the page."""
TEXTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = [page for page in TEXTS if blocks_of(page)]


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT).with_suffix("")) for page in PAGES])
def test_a_page_does_what_it_shows(page, tmp_path):
    blocks = blocks_of(page)
    with Session(tmp_path, FILES / page.stem) as session:
        for block in blocks:
            try:
                session.do(block)
            except Exception as error:
                raise AssertionError(f"{page.relative_to(ROOT)}:{block.line}: {error}") from error
        session.end()
