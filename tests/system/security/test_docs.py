"""What docs/security.md says is done: all its commands, from nothing, with the exit codes that it promises."""

from __future__ import annotations

import os
import re
import shlex
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT

PAGE = (ROOT / "docs" / "security.md").read_text(encoding="utf-8")
LINES = [line for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL) for line in block.splitlines()]
PATIENCE = 60.0


@pytest.fixture
def endpoint():
    """Return a free endpoint, in place of the page's port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{probe.getsockname()[1]}"


def test_the_commands_of_the_page_do_what_it_says(tmp_path, endpoint):
    """One after the other, in an empty folder; those that are denied exit with 1."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    simulator = None
    try:
        for line in LINES:
            command, _, remark = line.partition("#")
            words = shlex.split(command)
            if words[0] == "export":
                name, _, value = words[1].partition("=")
                environment[name] = value
            elif words[:2] == ["hmrsim", "run"]:
                simulator = subprocess.Popen(
                    [*words, "--listen", f"tls/{endpoint}"],
                    cwd=tmp_path,
                    env=environment,
                    stdout=subprocess.PIPE,
                    text=True,
                )
                assert f"ready tls/{endpoint}" in simulator.stdout.readline()
                environment["HMRSIM_CONNECT"] = f"tls/{endpoint}"
            else:
                words = [word.replace("127.0.0.1:7447", endpoint) for word in words]
                done = subprocess.run(
                    words, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
                )
                assert ("denied" in remark) == done.returncode, (line, done.stdout, done.stderr)
                assert ("may not ask" in done.stderr or "denied by" in done.stderr) == ("denied" in remark)
    finally:
        if simulator is not None:
            simulator.kill()
            simulator.communicate()
    assert simulator is not None
    assert len(LINES) > 10


def test_the_page_names_every_role_and_file():
    """Nothing that is in an enclave is left out."""
    for name in (
        "simulator",
        "viewer",
        "controller",
        "operator",
        "cert.pem",
        "key.pem",
        "policy.json",
        "session.json5",
    ):
        assert f"`{name}`" in PAGE
