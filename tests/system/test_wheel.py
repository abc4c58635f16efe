"""The wheel: installed in an empty environment, it runs from anywhere."""

from __future__ import annotations

import subprocess
import sys
import venv

import pytest

from tests.paths import ROOT


def install(binaries, *arguments):
    """Install in the environment of these commands, by the pip of ours: one for each takes its time."""
    pip = [sys.executable, "-m", "pip", "--python", str(binaries / "python"), "install", "--quiet", "--no-compile"]
    subprocess.run([*pip, *map(str, arguments)], check=True, capture_output=True)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Return the folder of the commands of a fresh environment in which the wheel is installed."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "env")
    binaries = folder / "env" / "bin"
    install(binaries, wheel)
    return binaries


@pytest.mark.timeout(300)
def test_the_demo_runs_from_elsewhere(installed, tmp_path):
    """Maps and schemas are in the wheel; the mission ends well."""
    words = [installed / "hmrsim", "demo", "--real-time-factor", "30"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)

    assert 0 == done.returncode, done.stdout + done.stderr


@pytest.mark.timeout(300)
def test_shipped_worlds_are_found_by_name(installed, tmp_path):
    """From any folder."""
    for world in ("scenario1", "scenario2", "hospital", "warehouse"):
        done = subprocess.run(
            [installed / "hmrsim", "map", "validate", world], cwd=tmp_path, capture_output=True, text=True, check=False
        )

        assert 0 == done.returncode, done.stdout + done.stderr


@pytest.mark.timeout(300)
def test_an_action_of_another_package_is_served(installed, tmp_path):
    """Installed beside ours, found by its entry point: in the list of actions and in the schemas."""
    (tmp_path / "dance.py").write_text(
        '"""Dance."""\n'
        "from dataclasses import replace\n"
        "from hmrsim.actions.wait import ACTION as WAIT\n"
        'ACTION = replace(WAIT, name="dance")\n'
    )
    (tmp_path / "pyproject.toml").write_text(
        '[build-system]\nrequires = ["hatchling"]\nbuild-backend = "hatchling.build"\n'
        '[project]\nname = "dancing"\nversion = "1"\n'
        '[project.entry-points."hmrsim.actions"]\ndance = "dance"\n'
        '[tool.hatch.build.targets.wheel]\ninclude = ["dance.py"]\n'
    )
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(tmp_path)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("dancing*.whl")
    install(installed, "--no-deps", wheel)
    simulator = subprocess.Popen(
        [installed / "hmrsim", "run", "scenario1", "--listen", "tcp/127.0.0.1:0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=tmp_path,
    )
    try:
        endpoint = simulator.stdout.readline().split()[1]
        sent = subprocess.run(
            [installed / "hmrsim", "action", "send-goal", "/wall_e/dance", "{time: {sec: 0}}", "--connect", endpoint],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    finally:
        simulator.terminate()
        simulator.communicate(timeout=30)
    subprocess.run([installed / "python", "-m", "hmrsim_zenoh.schemas", tmp_path / "schemas"], check=True)

    assert "Goal finished with status: SUCCEEDED" in sent.stdout
    assert (tmp_path / "schemas" / "actions" / "dance.schema.json").exists()
