"""The native world file: YAML, or JSON, which is nearly the same."""

from __future__ import annotations

import re

from hmrsim.documents.document import parse_document
from hmrsim.errors import WorldError
from hmrsim.world.files import AS_IT_IS, ReadOptions
from hmrsim.world.formats import Document, Format
from hmrsim.world.model import World

_KEYS = "|".join(World.model_fields)
_TOP_LEVEL_KEY = re.compile(rf"""^["']?({_KEYS})["']?[ ]*:""", re.MULTILINE)
_JSON_KEY = re.compile(rf'"({_KEYS})"\s*:')


def _matches(text: str) -> bool:
    return bool((_JSON_KEY if text.lstrip().startswith("{") else _TOP_LEVEL_KEY).search(text))


def _read(text: str, file: str, _options: ReadOptions = AS_IT_IS) -> Document:
    document = parse_document(text, file, WorldError, "a mapping with keys such as waypoints, lanes and robots")
    return Document(document.data, document.line, document.findings)


FORMAT = Format(name="native", suffixes=(".yaml", ".yml", ".json"), matches=_matches, read=_read, general=True)
