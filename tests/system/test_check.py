"""`hmrsim check` in worker processes."""

from __future__ import annotations

import json
import subprocess
import sys

import yaml

from tests.porters import HERE, WORLD


def summary(folder, *options):
    """Return the summary of a search without its wall times."""
    command = [sys.executable, "-m", "hmrsim.cli", "check", "world.yaml", "--python", "porters.py:vain", "--json"]
    done = subprocess.run([*command, *options], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    said = json.loads(done.stdout)
    del said["seconds"]
    for finding in said["findings"]:
        del finding["seconds"], finding["reducing"], finding["file"]
    return said


def test_a_search_is_the_same_with_one_process_and_with_two(tmp_path):
    (tmp_path / "world.yaml").write_text(yaml.safe_dump(WORLD), encoding="utf-8")
    (tmp_path / "porters.py").write_text((HERE / "porters.py").read_text("utf-8"), encoding="utf-8")

    one = summary(tmp_path, "--runs", "40", "-j", "1", "-o", "one")
    two = summary(tmp_path, "--runs", "40", "-j", "2", "-o", "two")

    assert one == two
    assert one["findings"]
    for path in sorted((tmp_path / "one" / "failures").iterdir()):
        assert path.read_bytes() == (tmp_path / "two" / "failures" / path.name).read_bytes()
