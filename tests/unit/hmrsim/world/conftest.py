"""Fixtures that load worlds written in tests."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import pytest

from hmrsim.errors import WorldError
from hmrsim.world_checks import load_world
from tests.unit.hmrsim.world.drawings import drawing

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    def write(text: str, name: str = "world.yaml") -> Path:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return path

    return write


@pytest.fixture
def load(write: Callable[..., Path]) -> Callable[..., LoadedWorld]:
    def load(text: str, name: str = "world.yaml") -> LoadedWorld:
        return load_world(write(text, name))

    return load


@pytest.fixture
def errors_of(write: Callable[..., Path]) -> Callable[..., list[str]]:
    def errors_of(text: str, name: str = "world.yaml") -> list[str]:
        path = write(text, name)
        with pytest.raises(WorldError) as caught:
            load_world(path)
        problems = [problem for problem in caught.value.problems if problem.severity == "error"]
        return [str(problem).removeprefix(f"{path}:").strip() for problem in problems]

    return errors_of


@pytest.fixture
def draw(load: Callable[..., LoadedWorld]) -> Callable[..., World]:
    return lambda *cells: load(drawing(*cells), "map.drawio").world


@pytest.fixture
def wrong(errors_of: Callable[..., list[str]]) -> Callable[..., list[str]]:
    return lambda *cells: errors_of(drawing(*cells), "map.drawio")


@pytest.fixture
def warned(load: Callable[..., LoadedWorld]) -> Callable[..., list[str]]:
    return lambda *cells: [
        str(warning).partition("map.drawio:1: ")[2] for warning in load(drawing(*cells), "map.drawio").warnings
    ]
