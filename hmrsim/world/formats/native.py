"""The native world file: YAML, or JSON, which is nearly the same."""

from __future__ import annotations

import re
from functools import partial

from hmrsim.diagnostics import shown
from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document, Format
from hmrsim.world.formats._json_text import as_yaml
from hmrsim.world.model import World
from hmrsim.world.options import AS_IT_IS, ReadOptions
from hmrsim.world.yaml_text import Unreadable, line_of, read

_KEYS = "|".join(World.model_fields)
_TOP_LEVEL_KEY = re.compile(rf"""^["']?({_KEYS})["']?[ ]*:""", re.MULTILINE)
_JSON_KEY = re.compile(rf'"({_KEYS})"\s*:')


def _matches(text: str) -> bool:
    return bool((_JSON_KEY if text.lstrip().startswith("{") else _TOP_LEVEL_KEY).search(text))


def _read(text: str, file: str, _options: ReadOptions = AS_IT_IS) -> Document:
    try:
        data, lines, findings = read(as_yaml(text) if text.lstrip().startswith("{") else text)
    except Unreadable as error:
        raise WorldError([Problem(file, "", str(error), error.line)]) from None
    if not isinstance(data, dict):
        message = f"expected a mapping with keys such as waypoints, lanes and robots, got {shown(data)}"
        raise WorldError([Problem(file, "", message, 1)])
    return Document(data, partial(line_of, lines), tuple(findings))


FORMAT = Format(name="native", suffixes=(".yaml", ".yml", ".json"), matches=_matches, read=_read, general=True)
