"""Reading a settings file: YAML or JSON, a key a setting."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.documents.document import read_document
from hmrsim.errors import SettingsError
from hmrsim.settings.model import together

if TYPE_CHECKING:
    from pathlib import Path


def read_file(path: Path, models: tuple[type, ...]) -> dict[str, Any]:
    """Return the settings of a file, by name.

    *models* declare the settings that the file may have.

    Raises:
        SettingsError: The file can't be read, or a setting is invalid; it has all problems.
    """
    document = read_document(path, SettingsError)
    if document.data is None:
        return {}
    document.check_mapping("a mapping with settings such as clock: lockstep")
    settings = document.validated(together(models))
    return {name: getattr(settings, name) for name in document.data}
