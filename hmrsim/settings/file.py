"""Reading a settings file: YAML or JSON, a key a setting."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, create_model

from hmrsim.documents.document import read_document
from hmrsim.errors import SettingsError
from hmrsim.settings.option import hints, settings_of

if TYPE_CHECKING:
    from pathlib import Path


@cache
def together(models: tuple[type, ...]) -> type[BaseModel]:
    """Return one model with the settings of several."""
    # Some models are dataclasses, so that tools need not load pydantic.
    fields: dict[str, Any] = {}
    for model in models:
        for name, setting in settings_of(model).items():
            fields[name] = (hints(model)[name], setting.default)
    config = ConfigDict(strict=True, extra="forbid", frozen=True)
    return create_model("Settings", __config__=config, __doc__="Settings of `hmrsim run`.", **fields)


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
