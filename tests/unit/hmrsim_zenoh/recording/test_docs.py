"""What docs/reference/recording.md shows in Python does what it says."""

from __future__ import annotations

import re

import pytest

from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import SendGoal
from tests.paths import ROOT

_EXAMPLES = re.findall(
    r"```python\n(.*?)```", ROOT.joinpath("docs", "reference", "recording.md").read_text(), re.DOTALL
)


@pytest.mark.parametrize(
    ("example", "said"),
    [*zip(_EXAMPLES, ("10.0 s\n", '"kind":"goal"', "geometry_msgs__msg__Point(x=1.0"), strict=True)],
)
def test_an_example_runs(example, said, record, tmp_path, monkeypatch, capsys):
    """Next to a recording `run.mcap`."""
    record((0.0, SendGoal("wall_e", "wait", Wait.Goal(), "1" * 32)), path=tmp_path / "run.mcap")
    monkeypatch.chdir(tmp_path)

    exec(compile(example, "docs/reference/recording.md", "exec"), {})

    assert said in capsys.readouterr().out
