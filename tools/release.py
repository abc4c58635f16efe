"""Checks that what would be released is right: ``python -m tools.release``, which writes ``dist/``.

The wheel and the source distribution are built twice, from two copies of the committed files, and have to be the same,
byte for byte; the wheel has its bill of materials; installed in an empty environment it works, and is neither large
nor slow to install.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
import venv
import zipfile
from pathlib import Path
from typing import Final

_ROOT: Final = Path(__file__).parents[1]
_DIST: Final = _ROOT / "dist"
_MOST_BYTES: Final = 160_000_000
_MOST_SECONDS: Final = 30.0
_NEEDED: Final = ("hmrsim/data/maps/cafe.yaml", "hmrsim/data/schemas/world.schema.json", "hmrsim/cli/world_new.yaml")
_COMMANDS: Final = (
    ("hmrsim", "--version"),
    ("bt-controller", "--version"),
    ("hmrsim", "simulate", "warehouse"),
    ("hmrsim", "explain", "208"),
    ("hmrsim", "demo", "--clock", "lockstep"),
)


def main() -> int:
    """Build, compare, install and try; return 1 if something is wrong."""
    with tempfile.TemporaryDirectory() as folder:
        first, second = (_built(Path(folder) / name) for name in ("one", "two"))
        wrong = [f"{name}: built twice, it differs" for name in first if first[name] != second.get(name)]
        if _DIST.exists():
            shutil.rmtree(_DIST)
        shutil.copytree(Path(folder) / "one" / "dist", _DIST)
        for name, digest in first.items():
            _say(f"{digest}  {name}")
        (wheel,) = _DIST.glob("*.whl")
        wrong += [*_of_wheel(wheel), *_of_installation(wheel, Path(folder) / "environment")]
    for line in wrong:
        sys.stderr.write(f"{line}\n")
    return 1 if wrong else 0


def _built(folder: Path) -> dict[str, str]:
    """Build what is committed, in a folder of its own; return the digests."""
    folder.mkdir()
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=_ROOT, check=True, capture_output=True).stdout
    subprocess.run(["tar", "-x"], cwd=folder, input=archive, check=True)
    at = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=_ROOT, check=True, capture_output=True, text=True)
    environment = {**os.environ, "SOURCE_DATE_EPOCH": at.stdout.strip(), "PYTHONHASHSEED": "random"}
    build = [sys.executable, "-m", "build", "--no-isolation"]
    subprocess.run(build, cwd=folder, check=True, capture_output=True, env=environment)
    files = sorted((folder / "dist").iterdir())
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def _of_wheel(wheel: Path) -> list[str]:
    names = zipfile.ZipFile(wheel).namelist()
    wrong = [f"{wheel.name}: lacks {name}" for name in _NEEDED if name not in names]
    if not any(".dist-info/sboms/" in name for name in names):
        wrong.append(f"{wheel.name}: lacks its bill of materials")
    return wrong + [f"{wheel.name}: has {name}" for name in names if name.startswith(("tests/", "tools/"))]


def _of_installation(wheel: Path, environment: Path) -> list[str]:
    began = time.monotonic()
    venv.create(environment, with_pip=True)
    binaries = environment / "bin"
    subprocess.run([binaries / "python", "-m", "pip", "install", "--quiet", wheel], check=True)
    seconds = time.monotonic() - began
    pip = ("pip", "setuptools")
    there = [path for path in environment.rglob("*") if path.is_file() and not path.is_symlink()]
    size = sum(path.stat().st_size for path in there if not any(part in pip for part in path.parts))
    _say(f"installed in {seconds:.1f} s, {size / 1e6:.0f} MB")
    wrong = []
    if size > _MOST_BYTES:
        wrong.append(f"{size / 1e6:.0f} MB are installed; at most {_MOST_BYTES / 1e6:.0f} MB are wanted")
    if seconds > _MOST_SECONDS:
        wrong.append(f"the installation took {seconds:.1f} s; at most {_MOST_SECONDS:g} s are wanted")
    for words in _COMMANDS:
        done = subprocess.run([binaries / words[0], *words[1:]], cwd=environment, capture_output=True, check=False)
        if done.returncode:
            wrong.append(f"{' '.join(words)}: exit code {done.returncode}: {done.stderr.decode()[-300:]}")
    return wrong


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")


if __name__ == "__main__":
    sys.exit(main())
