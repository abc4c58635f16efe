"""What docs/reference/security.md says is done: all commands, from nothing, with the exit codes that it promises."""

from __future__ import annotations

import os
import re
import shlex
import socket
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests import processes
from tests.paths import ROOT

PAGE = (ROOT / "docs" / "reference" / "security.md").read_text(encoding="utf-8")
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
    ran = []
    with ExitStack() as stack:
        for line in LINES:
            command, _, remark = line.partition("#")
            words = [word.replace("127.0.0.1:7447", endpoint) for word in shlex.split(command)]
            if words[0] == "export":
                name, _, value = words[1].partition("=")
                environment[name] = value
                continue
            own = dict(environment)
            if words[:2] == ["env", "-u"]:
                # Without the program, which a bare machine may lack.
                del own[words[2]]
                words = words[3:]
                ran.append("env")
            if words[:2] == ["hmrsim", "run"]:
                words += ["--listen", f"tls/{endpoint}"]
            process = stack.enter_context(processes.start(*words, cwd=tmp_path, env=own))
            stack.callback(process.kill)
            if words[:2] == ["hmrsim", "run"]:
                assert f"ready tls/{endpoint}" in process.stdout.readline()
                environment["HMRSIM_CONNECT"] = f"tls/{endpoint}"
                continue
            output, errors = process.communicate(timeout=PATIENCE)
            assert ("denied" in remark) == process.returncode, (line, output, errors)
            assert ("may not ask" in errors or "denied by" in errors) == ("denied" in remark)
            ran.append(words[0])
    assert {"hmrsim", "bt-controller", "env"} == set(ran)


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
