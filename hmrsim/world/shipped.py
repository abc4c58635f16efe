"""Files that are shipped with hmrsim: worlds and schemas."""

from __future__ import annotations

from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def folder(kind: str) -> Path:
    """Return the folder of the shipped ``maps`` or ``schemas``, in a wheel or in a source checkout."""
    installed = _PACKAGE / "data" / kind
    return installed if installed.is_dir() else _PACKAGE.parent / kind


def shipped_maps() -> dict[str, Path]:
    """Return the shipped worlds by bare name, such as ``hospital`` and ``zoo/crossing``, in order of name."""
    return dict(_maps_in(folder("maps")))


@cache
def _maps_in(maps: Path) -> dict[str, Path]:
    found = {path.relative_to(maps).with_suffix("").as_posix(): path for path in maps.rglob("*.yaml")}
    return dict(sorted(found.items()))
