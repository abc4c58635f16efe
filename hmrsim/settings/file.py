"""Reading a settings file: YAML or JSON, a key a setting."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hmrsim.diagnostics import MAX_FINDINGS, Finding, problems_of, shown
from hmrsim.errors import Problem, SettingsError, WorldError
from hmrsim.settings.model import together
from hmrsim.world.files import read_text
from hmrsim.world.formats._json_text import as_yaml
from hmrsim.world.yaml_text import Unreadable, line_of, read
from hmrsim.world_checks.explain import explain

if TYPE_CHECKING:
    from pathlib import Path

    from pydantic import BaseModel


def read_file(path: Path, models: tuple[type, ...]) -> dict[str, Any]:
    """Return the settings of a file, by name.

    *models* have all settings that it may have.

    Raises:
        SettingsError: It can't be read, or a setting is invalid; it has all problems.
    """
    file = str(path)
    try:
        text = read_text(path, file)
        data, lines, findings = read(as_yaml(text) if text.lstrip().startswith("{") else text)
    except WorldError as error:
        raise SettingsError(error.problems) from None
    except Unreadable as error:
        raise SettingsError([Problem(file, "", str(error), error.line)]) from None
    if data is None:
        return {}
    if not isinstance(data, dict):
        text = f"expected a mapping with settings such as clock: lockstep, got {shown(data)}"
        raise SettingsError([Problem(file, "", text, 1)])
    found, wrong = _validated(data, together(models))
    wrong = [*findings, *wrong]
    if wrong:
        problems = problems_of(wrong, file, partial(line_of, lines))
        more = len(problems) - MAX_FINDINGS
        last = [Problem(file, "", f"and {more} more")] if more > 0 else []
        raise SettingsError([*problems[:MAX_FINDINGS], *last])
    return found


def _validated(data: dict[str, Any], model: type[BaseModel]) -> tuple[dict[str, Any], list[Finding]]:
    """Return the settings of a mapping, and its errors."""
    try:
        settings = model.model_validate(data)
    except ValidationError as error:
        return {}, explain(error, data, model)
    return {name: getattr(settings, name) for name in data}, []
