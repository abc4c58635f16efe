"""Files that hmrsim brings along: worlds and schemas."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def folder(kind: str) -> Path:
    """Return the folder of the shipped ``maps`` or ``schemas``, in a wheel or in a source checkout."""
    installed = _PACKAGE / "data" / kind
    return installed if installed.is_dir() else _PACKAGE.parent / kind


def shipped_maps() -> dict[str, Path]:
    """Return the shipped worlds by bare name, in order of name."""
    return {path.stem: path for path in sorted(folder("maps").glob("*.yaml"))}
