"""The output of `make audit`: vulnerabilities, or the reason why nothing was audited."""

from __future__ import annotations

import json
import subprocess
from types import SimpleNamespace

import pytest

from tools import audit


@pytest.fixture
def said(monkeypatch, capsys):
    """Return the function that runs the audit on what pip-audit writes: exit code and text."""

    def run(stdout, stderr=""):
        answer = stdout if isinstance(stdout, str) else json.dumps({"dependencies": stdout})
        monkeypatch.setattr(subprocess, "run", lambda *_, **__: SimpleNamespace(stdout=answer, stderr=stderr))
        return audit.main(), capsys.readouterr().out

    return run


def test_a_vulnerability_is_told_with_its_remedy(said):
    """It makes the target fail, which CI only shows."""
    vulnerable = {"name": "a", "version": "1.0", "vulns": [{"id": "PYSEC-1", "fix_versions": ["1.1"]}]}
    code, text = said([vulnerable, {"name": "b", "version": "2.0", "vulns": []}])

    assert 1 == code
    assert ["a 1.0: PYSEC-1, fixed in 1.1", "2 of 2 packages audited: 1 known vulnerabilities"] == text.splitlines()


@pytest.mark.parametrize(
    ("stdout", "stderr", "text"),
    [
        ("", "Traceback\nConnectionError: no route", "not audited: ConnectionError: no route\n"),
        ("", "", "not audited: pip-audit says nothing\n"),
        ([{"name": "a", "skip_reason": "not found on PyPI"}], "", "not audited: not found on PyPI\n"),
    ],
)
def test_without_an_index_it_says_so_and_passes(said, stdout, stderr, text):
    assert (0, text) == said(stdout, stderr)
