"""Writes the tables of events in ``docs/``, each between ``<!-- events: GROUP -->`` and ``<!-- end of events -->``.

Run as ``python -m tools.event_tables [--check]``; the tables are generated and never edited.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.events import groups

if TYPE_CHECKING:
    from hmrsim.events import Event

_DOCS: Final = Path(__file__).parents[1] / "docs"
_TABLE: Final = re.compile(r"(<!-- events: ([a-z_ ]+) -->\n).*?(<!-- end of events -->)", re.DOTALL)


def table_of(names: str) -> str:
    """Return the table of some groups' events."""
    lines = ["| event | | fields |", "|---|---|---|"]
    for name in names.split():
        lines += [
            f"| `{event.kind}` | {_summary(event)} | {', '.join(_fields(event))} |" for event in groups()[name].events
        ]
    return "\n".join(lines) + "\n"


def _summary(event: type[Event]) -> str:
    return (event.__doc__ or "").partition("\n")[0].rstrip(".")


def _fields(event: type[Event]) -> Iterator[str]:
    for field in event._fields:
        if field == event.rest:
            yield "its settings"
        else:
            yield f"`{field.rstrip('_')}`{' (optional)' if field in event._field_defaults else ''}"


def main(argv: Sequence[str] | None = None) -> int:
    """Write the tables, or report which are out of date."""
    parser = argparse.ArgumentParser(prog="python -m tools.event_tables", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a table is out of date")
    check, stale, shown = parser.parse_args(argv).check, 0, set[str]()
    for path in sorted(_DOCS.rglob("*.md")):
        text = path.read_text(encoding="utf-8")
        shown |= {name for _, names, _ in _TABLE.findall(text) for name in names.split()}
        made = _TABLE.sub(lambda found: f"{found[1]}{table_of(found[2])}{found[3]}", text)
        if made != text and check:
            sys.stderr.write(f"{path}: tables of events are out of date; run make schemas\n")
            stale += 1
        elif made != text:
            path.write_text(made, encoding="utf-8")
    for name in sorted({*groups()} - shown):
        sys.stderr.write(f"{_DOCS}: no table shows the events of {name}; add <!-- events: {name} -->\n")
        stale += 1
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
