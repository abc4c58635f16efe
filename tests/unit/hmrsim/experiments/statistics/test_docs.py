"""The example in docs/reference/statistics.md holds as it stands there."""

from __future__ import annotations

import re

from tests.paths import ROOT


def test_the_example_of_the_docs():
    """Each line is run, with its assertions."""
    (block,) = re.findall(
        r"```python\n(.*?)```", (ROOT / "docs" / "reference" / "statistics.md").read_text(), re.DOTALL
    )

    exec(block, {})
