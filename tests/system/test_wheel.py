"""The wheel, installed in an empty environment by the steps of Containerfile."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import venv
from importlib.metadata import distributions

import pytest
from packaging.utils import canonicalize_name

from hmrsim import __version__
from tests.paths import ROOT
from tests.system import containerfile


def install(binaries, *arguments):
    """Install packages in the environment with the pip of this one."""
    pip = [sys.executable, "-m", "pip", "--python", str(binaries / "python"), "install", "--quiet", "--no-compile"]
    subprocess.run([*pip, *map(str, arguments)], check=True, capture_output=True)


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    """Return a fresh environment built by the steps of Containerfile, and its user."""
    folder = tmp_path_factory.mktemp("image")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder / "dist"), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    shutil.copy(ROOT / "requirements.lock", folder)
    venv.create(folder / "env")
    return folder / "env", containerfile.install(folder, folder / "env", folder / "root")


@pytest.fixture(scope="module")
def installed(image):
    """Return the folder with the commands of that environment."""
    environment, _ = image
    return environment / "bin"


def test_the_image_contains_neither_wheel_nor_lock_file(image):
    environment, _ = image
    _, folder = containerfile.copied()

    assert not (environment.parent / "root" / folder.strip("/")).exists()


def test_the_image_is_built_from_released_files_only():
    lines = (ROOT / ".dockerignore").read_text().splitlines()
    sources, _ = containerfile.copied()

    assert ["*", *(f"!{source}" for source in sources)] == [line for line in lines if not line.startswith("#")]


def test_the_container_runs_as_a_numbered_user(image):
    """Clusters can check a number, and not a name, for root."""
    _, user = image
    names = [name for name, _ in containerfile.STEPS]

    assert containerfile.argument_of("USER") == user[user.index("--uid") + 1] != "0"
    assert names.index("RUN") < names.index("USER") < names.index("ENTRYPOINT")


def test_the_bill_of_materials_lists_the_installed_packages(installed):
    """The version may depend on that of Python."""
    (folder,) = installed.parent.glob("lib/python*/site-packages")
    (bill,) = folder.glob("hmrsim-*.dist-info/sboms/*.json")
    listed = {one["name"] for one in json.loads(bill.read_text())["components"] if "pkg:pypi/" in one["purl"]}
    there = {canonicalize_name(one.name): one.version for one in distributions(path=[str(folder)])}
    locked = {line.split(" ")[0] for line in (ROOT / "requirements.lock").read_text().splitlines()}

    assert there.pop("hmrsim") == __version__
    # Another test may have installed its package here before.
    there.pop("dancing", None)
    assert listed == there.keys()
    assert {f"{name}=={version}" for name, version in there.items()} < locked


def test_the_health_check_tells_whether_the_entry_point_runs(installed, tmp_path):
    words = [*containerfile.words_of("ENTRYPOINT"), *containerfile.words_of("CMD")]
    program, *arguments = [word.replace("0.0.0.0:7447", "127.0.0.1:0") for word in words]
    check, *options = containerfile.words_of("HEALTHCHECK")
    quiet = {"cwd": tmp_path, "stderr": subprocess.DEVNULL, "text": True, "stdout": subprocess.PIPE}
    with subprocess.Popen([installed / program, *arguments], **quiet) as process:
        where = process.stdout.readline().split()[1]
        health = [installed / check, *options, "--connect", where]
        while_it_runs = subprocess.run(health, **quiet, check=False)
        process.terminate()
    afterwards = subprocess.run([*health, "--timeout", "0.5"], **quiet, check=False)

    assert (0, 3) == (while_it_runs.returncode, afterwards.returncode)
    assert "latte" in while_it_runs.stdout


def test_the_demo_runs_from_any_folder(installed, tmp_path):
    words = [installed / "hmrsim", "demo", "--real-time-factor", "30"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert 0 == done.returncode, done.stdout + done.stderr


def test_shipped_worlds_are_found_by_name(installed, tmp_path):
    for world in ("scenario1", "scenario2", "hospital", "warehouse"):
        done = subprocess.run(
            [installed / "hmrsim", "map", "validate", world], cwd=tmp_path, capture_output=True, text=True, check=False
        )

        assert 0 == done.returncode, done.stdout + done.stderr


def test_an_action_of_another_package_is_served(installed, tmp_path):
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
            check=False,
        )
    finally:
        simulator.terminate()
        simulator.communicate()
    subprocess.run([installed / "python", "-m", "hmrsim_zenoh.schemas", tmp_path / "schemas"], check=True)

    assert "Goal finished with status: SUCCEEDED" in sent.stdout
    assert (tmp_path / "schemas" / "actions" / "dance.schema.json").exists()
