"""The image that Containerfile makes: its steps, as far as they can be tried without a container."""

from __future__ import annotations

import json
import re
import subprocess
import sys

from tests import processes
from tests.paths import ROOT

STEPS = [
    tuple(line.split(" ", 1))
    for line in (ROOT / "Containerfile").read_text().splitlines()
    if re.match(r"[A-Z]+ ", line)
]


def words_of(instruction):
    """Return the words of the last instruction of this name, in its form for exec."""
    text = [rest for name, rest in STEPS if name == instruction][-1]
    return json.loads(text[text.index("[") :])


def test_it_has_no_root_and_says_whether_it_is_well():
    """Nor anything that is fetched but the image that it builds on."""
    names = [name for name, _ in STEPS]

    assert ["10001"] == [rest for name, rest in STEPS if name == "USER"]
    assert names.index("RUN") < names.index("USER") < names.index("ENTRYPOINT")
    assert ["FROM", "HEALTHCHECK"] == [name for name in names if name in {"FROM", "HEALTHCHECK", "ADD"}]


def test_the_health_check_succeeds_when_the_entry_point_runs_and_fails_when_not():
    """Both are the commands of the file, on a free port."""
    words = [word.replace("0.0.0.0:7447", "127.0.0.1:0") for word in (*words_of("ENTRYPOINT"), *words_of("CMD"))]
    with processes.start(*words, stderr=subprocess.DEVNULL) as process:
        where = process.stdout.readline().split()[1]
        program, *check = words_of("HEALTHCHECK")
        with processes.start(program, *check, "--connect", where) as health:
            assert 0 == health.wait(30)
        process.kill()
    with processes.start(program, *check, "--connect", where, "--timeout", "0.5") as health:
        assert 3 == health.wait(30)


def test_the_installation_is_of_files_that_a_release_has(tmp_path):
    """The wheel is copied to where it is installed from."""
    copied = next(rest for name, rest in STEPS if name == "COPY").split()
    (install,) = (rest for name, rest in STEPS if name == "RUN")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)

    assert len([*tmp_path.glob(copied[0].removeprefix("dist/"))]) == 1
    assert install.startswith(f"pip install --no-cache-dir --no-compile {copied[1]}*.whl && ")
