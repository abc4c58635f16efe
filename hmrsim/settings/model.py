"""Models of settings: what they have in common, and one model of several."""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import BaseModel, ConfigDict, create_model

from hmrsim.settings.option import hints, settings_of


class Settings(BaseModel):
    """The base of models of settings."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", defer_build=True)


@cache
def together(models: tuple[type, ...]) -> type[BaseModel]:
    """Return one model of the settings of several."""
    # Built here, as two of its parts are not pydantic models, so that tools need not load pydantic.
    fields: dict[str, Any] = {}
    for model in models:
        for name, setting in settings_of(model).items():
            fields[name] = (hints(model)[name], setting.default)
    config = ConfigDict(strict=True, extra="forbid", frozen=True)
    return create_model("Settings", __config__=config, __doc__="Settings of `hmrsim run`.", **fields)
