"""The native world file: YAML, or JSON, which is nearly the same."""

from __future__ import annotations

import re
from functools import partial

from hmrsim.errors import Problem, WorldError
from hmrsim.world.finding import shown
from hmrsim.world.formats import Document, Format
from hmrsim.world.model import World
from hmrsim.world.options import AS_IT_IS, ReadOptions
from hmrsim.world.yaml_text import Unreadable, line_of, read

_KEYS = "|".join(World.model_fields)
_TOP_LEVEL_KEY = re.compile(rf"""^["']?({_KEYS})["']?[ ]*:""", re.MULTILINE)
_JSON_KEY = re.compile(rf'"({_KEYS})"\s*:')
_SURROGATES = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")


def _matches(text: str) -> bool:
    return bool((_JSON_KEY if text.lstrip().startswith("{") else _TOP_LEVEL_KEY).search(text))


def _read(text: str, file: str, _options: ReadOptions = AS_IT_IS) -> Document:
    try:
        data, lines, findings = read(_from_json(text) if text.lstrip().startswith("{") else text)
    except Unreadable as error:
        raise WorldError([Problem(file, "", str(error), error.line)]) from None
    if not isinstance(data, dict):
        message = f"expected a mapping with keys such as waypoints, lanes and robots, got {shown(data)}"
        raise WorldError([Problem(file, "", message, 1)])
    return Document(data, partial(line_of, lines), tuple(findings))


def _from_json(text: str) -> str:
    """Return JSON as YAML: tabs between values and characters written as two surrogates are not YAML."""
    return _SURROGATES.sub(_join, text.replace("\t", " "))


def _join(match: re.Match[str]) -> str:
    high, low = int(match[2], 16), int(match[3], 16)
    return f"{match[1]}\\U{0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00):08x}"


FORMAT = Format(name="native", suffixes=(".yaml", ".yml", ".json"), matches=_matches, read=_read)
