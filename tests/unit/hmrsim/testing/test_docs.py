"""The tests in docs/reference/testing.md pass as they stand there."""

from __future__ import annotations

import re

from tests.paths import ROOT

pytest_plugins = ["pytester"]


def test_they_pass(pytester):
    """In a process of their own, as a user's."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "reference" / "testing.md").read_text(), re.DOTALL)
    pytester.makepyfile("\n".join(blocks))

    pytester.runpytest_subprocess("-p", "no:randomly").assert_outcomes(passed=len(blocks))
