"""Builds and checks a release: ``python -m tools.release`` writes ``dist/``.

Wheel and source distribution are built twice, from two copies of the committed files and in different surroundings, and
have to be the same, byte for byte. The wheel has what it needs and nothing else; installed in an empty environment it
works, and is neither large nor slow to install. A commit that has a tag is of the version that the tag says.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import venv
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

_ROOT: Final = Path(__file__).parents[1]
_DIST: Final = _ROOT / "dist"
_MAX_BYTES: Final = 160_000_000
_MAX_SECONDS: Final = 30.0
_SURROUNDINGS: Final[tuple[tuple[int, Mapping[str, str]], ...]] = (
    (0o022, {"TZ": "UTC", "LC_ALL": "C.UTF-8", "PYTHONHASHSEED": "1"}),
    (0o077, {"TZ": "Pacific/Kiritimati", "LC_ALL": "C", "PYTHONHASHSEED": "2"}),
)
"""Of each build: the mask of new files' rights, and variables."""
_NEEDED: Final = ("hmrsim/data/maps/cafe.yaml", "hmrsim/data/schemas/world.schema.json", "hmrsim/cli/map_new.yaml")
_TWINE: Final = "twine>=6.1,<8"
_COMMANDS: Final = (
    ("hmrsim", "--version"),
    ("hmrsim", "simulate", "warehouse"),
    ("hmrsim", "explain", "208"),
    ("hmrsim", "demo", "--clock", "lockstep"),
    ("bt-controller", "--help"),
)


def main() -> int:
    """Build, compare, install and try; return 1 if something is wrong."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if left_out := _output("git", "status", "--porcelain"):
            _say(f"left out, as they are not committed: changes of {len(left_out.splitlines())} files")
        first, second = (_built(folder / str(number), *how) for number, how in enumerate(_SURROUNDINGS))
        wrong = different(first, second)
        shutil.rmtree(_DIST, ignore_errors=True)
        shutil.copytree(folder / "0" / "dist", _DIST)
        for file, digest in first.items():
            _say(f"{digest}  {file}")
        (wheel,) = _DIST.glob("*.whl")
        changes = (_ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
        wrong += wrong_tags(wheel.name.split("-")[1], _output("git", "tag", "--points-at").split(), changes)
        packages = tomllib.loads((_ROOT / "pyproject.toml").read_text(encoding="utf-8"))
        wrong += wrong_contents(wheel, packages["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"])
        wrong += [*_of_metadata(folder / "twine"), *_of_installation(wheel, folder / "environment")]
    for line in wrong:
        sys.stderr.write(f"{line}\n")
    return 1 if wrong else 0


def _built(folder: Path, umask: int, variables: Mapping[str, str]) -> dict[str, str]:
    """Build the committed files in a new folder, and return the digests."""
    folder.mkdir()
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=_ROOT, check=True, capture_output=True).stdout
    subprocess.run(["tar", "-x", "--no-same-permissions"], cwd=folder, input=archive, check=True, umask=umask)
    environment = {**os.environ, **variables, "SOURCE_DATE_EPOCH": _output("git", "log", "-1", "--format=%ct")}
    _output(sys.executable, "-m", "build", "--no-isolation", cwd=folder, env=environment, umask=umask)
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in sorted((folder / "dist").iterdir())}


def different(first: Mapping[str, str], second: Mapping[str, str]) -> list[str]:
    """Return the differences between two builds, by the digests of their files."""
    names = sorted(first.keys() | second.keys())
    return [f"{name}: built twice, it differs" for name in names if first.get(name) != second.get(name)]


def wrong_tags(version: str, tags: list[str], changes: str) -> list[str]:
    """Return the errors in the tags of a release; a commit without tags has none."""
    wrong = [f"tag {tag}: the version is {version}; expected v{version}" for tag in tags if tag != f"v{version}"]
    if tags and f"\n## [{version}]" not in changes:
        wrong.append(f"CHANGELOG.md: no section [{version}]; what is new in it stands under [Unreleased]")
    return wrong


def wrong_contents(wheel: Path, packages: list[str]) -> list[str]:
    """Return the files that the wheel lacks, and files outside its packages."""
    names = zipfile.ZipFile(wheel).namelist()
    wrong = [f"{wheel.name}: lacks {name}" for name in _NEEDED if name not in names]
    if not any(".dist-info/sboms/" in name for name in names):
        wrong.append(f"{wheel.name}: lacks its bill of materials")
    folders = sorted({name.split("/")[0] for name in names} - {*packages})
    return wrong + [f"{wheel.name}: has {name}" for name in folders if not name.endswith(".dist-info")]


def _of_metadata(environment: Path) -> Iterator[str]:
    """Yield the errors that twine reports in the metadata."""
    python = _environment(environment)
    _output(python, "-m", "pip", "install", "--quiet", _TWINE)
    done = subprocess.run(
        [python, "-m", "twine", "check", "--strict", *_DIST.iterdir()], capture_output=True, text=True, check=False
    )
    if done.returncode:
        yield done.stdout + done.stderr


def _of_installation(wheel: Path, environment: Path) -> Iterator[str]:
    """Yield the errors of the wheel after an installation without pip's cache."""
    began = time.monotonic()
    python = _environment(environment)
    _output(python, "-m", "pip", "install", "--quiet", "--no-cache-dir", wheel)
    seconds = time.monotonic() - began
    there = [path for path in environment.rglob("*") if path.is_file() and not path.is_symlink()]
    size = sum(path.stat().st_size for path in there if not {"pip", "setuptools"} & {*path.parts})
    _say(f"installed in {seconds:.1f} s, {size / 1e6:.0f} MB")
    if size > _MAX_BYTES:
        yield f"{size / 1e6:.0f} MB are installed; expected at most {_MAX_BYTES / 1e6:.0f} MB"
    if seconds > _MAX_SECONDS:
        yield f"the installation took {seconds:.1f} s; expected at most {_MAX_SECONDS:g} s"
    for program, *arguments in _COMMANDS:
        words: list[str | Path] = [python.with_name(program), *arguments]
        done = subprocess.run(words, cwd=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            yield f"{program} {' '.join(arguments)}: exit code {done.returncode}: {done.stderr[-300:]}"


def _environment(folder: Path) -> Path:
    """Make an empty environment, and return its Python."""
    venv.create(folder, with_pip=True)
    return folder / "bin" / "python"


def _output(*words: str | Path, cwd: Path = _ROOT, env: Mapping[str, str] | None = None, umask: int = -1) -> str:
    """Return the output of a program; exit with all of it if the program fails."""
    done = subprocess.run(words, cwd=cwd, env=env, umask=umask, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout.strip()


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")


if __name__ == "__main__":
    sys.exit(main())
