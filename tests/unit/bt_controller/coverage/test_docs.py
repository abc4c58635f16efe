"""The programs in docs/reference/coverage.md do what they say."""

from __future__ import annotations

import re

from tests.paths import ROOT

pytest_plugins = ["pytester"]


def test_they_pass(pytester):
    """In a process of their own, as a user's."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "reference" / "coverage.md").read_text(), re.DOTALL)
    pytester.makepyfile("\n".join(blocks))

    pytester.runpytest_subprocess("-p", "no:randomly").assert_outcomes(passed=1)
