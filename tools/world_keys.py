"""Writes the reference of the keys of world files from their schema.

Run as ``python -m tools.world_keys [--check]``; docs/reference/world_keys.md is generated.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from hmrsim.world_checks.schema import world_schema

_PAGE: Final = Path("docs/reference/world_keys.md")
_HEAD: Final = """\
# Keys of a world

<!-- generated from the schema of worlds by `make schemas`, not to be edited -->

This page lists each key of a world file with its type and default. [Worlds](worlds.md) explains how to use them.
`hmrsim map schema` prints the schema, which editors use to complete keys.
"""

_Schema = Mapping[str, Any]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the page, or report that it is out of date."""
    parser = argparse.ArgumentParser(prog="python -m tools.world_keys", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if something is wrong")
    arguments = parser.parse_args(argv)
    schema = world_schema()
    new = "\n".join([_HEAD, *_section("World", schema), *_definitions(schema["$defs"])]) + "\n"
    if arguments.check and (not _PAGE.exists() or _PAGE.read_text(encoding="utf-8") != new):
        sys.stderr.write(f"{_PAGE}: out of date; run make schemas\n")
        return 1
    if not arguments.check:
        _PAGE.write_text(new, encoding="utf-8")
    return 0


def _definitions(definitions: _Schema) -> Iterator[str]:
    for name, definition in definitions.items():
        cases = [part for part in definition.get("anyOf", ()) if "properties" in part]
        if "properties" in definition:
            yield from _section(name, definition)
        for case in cases:
            yield from _section(" ".join([name, *_constants(case)]), case)
        yield from _components(name, definition)


def _components(name: str, definition: _Schema) -> Iterator[str]:
    if name == "RobotType":
        for component, settings in definition["properties"]["components"]["properties"].items():
            yield from _section(f"component {component}", settings)


def _constants(case: _Schema) -> list[str]:
    return [str(part["const"]) for part in case["properties"].values() if "const" in part]


def _section(name: str, schema: _Schema) -> Iterator[str]:
    yield f"## {_words(name)}\n\n{_cell(schema['description'])}\n\n| key | type | default | |\n|---|---|---|---|"
    required = schema.get("required", ())
    for key, part in schema["properties"].items():
        default = "required" if key in required else f"`{json.dumps(part['default'])}`" if _tells(part) else ""
        yield f"| `{key}` | {_type(part)} | {default} | {_cell(part.get('description', ''))} |"
    yield ""


def _tells(part: _Schema) -> bool:
    return part.get("default") not in (None, {}, [])


def _type(part: _Schema) -> str:
    """Return the type of a key in words, with a link to its section."""
    if "$ref" in part:
        return _words(part["$ref"].rpartition("/")[2]).lower()
    if "const" in part or "enum" in part:
        return " or ".join(f"`{value}`" for value in part.get("enum", [part.get("const")]))
    for several in ("anyOf", "oneOf"):
        if several in part:
            return " or ".join(dict.fromkeys(map(_type, part[several])))
    kind = part.get("type", "anything")
    if kind == "array":
        return f"list of {_type(part['items'])}" if isinstance(part.get("items"), dict) else "list"
    if kind == "object":
        values = part.get("additionalProperties")
        return f"mapping to {_type(values)}" if isinstance(values, dict) and values else "mapping"
    bounds = [f"{sign} {part[key]:g}" for key, sign in _BOUNDS.items() if key in part]
    return " ".join([str(kind), *bounds])


_BOUNDS: Final = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def _words(name: str) -> str:
    """Return the name of a part of a world as users write it."""
    name = name.replace("RobotSpec", "Robot").replace("FaultEntry", "Fault")
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).capitalize()


def _cell(text: str) -> str:
    """Return a text of a docstring for the page: on one line, with JSON's null in place of None."""
    return " ".join(re.sub(r"\bNone\b", "null", text).split()).replace("``", "`").replace("|", "\\|")


if __name__ == "__main__":
    sys.exit(main())
