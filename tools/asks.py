"""Writes the list of examples that answer questions from users of robotics software.

Run as ``python -m tools.asks [--check]``; docs/how_to/asks.md is generated from the docstrings of `examples/asks`.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

_EXAMPLES: Final = Path("examples/asks")
_PAGE: Final = Path("docs/how_to/asks.md")
_ISSUE: Final = re.compile(r"https://github\.com/([\w.-]+/[\w.-]+)/(?:issues|pull)/(\d+)")
_HEAD: Final = """\
# What users ask for

<!-- generated from examples/asks by `make schemas`, not to be edited -->

Each row is a question from the issues of another project, and an example that answers it.
An example is one file with a world, a controller and a test, which you can copy.
`pytest examples/asks` runs all of them in a few seconds.

| question | asked in | example |
|---|---|---|
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Write the page, or report that it is out of date."""
    parser = argparse.ArgumentParser(prog="python -m tools.asks", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if something is wrong")
    arguments = parser.parse_args(argv)
    files = sorted(_EXAMPLES.glob("test_*.py"))
    new = _HEAD + "".join(map(line_of, files)) + "".join(map(section_of, files))
    if arguments.check and (not _PAGE.exists() or _PAGE.read_text(encoding="utf-8") != new):
        sys.stderr.write(f"{_PAGE}: out of date; run make schemas\n")
        return 1
    if not arguments.check:
        _PAGE.parent.mkdir(exist_ok=True)
        _PAGE.write_text(new, encoding="utf-8")
    return 0


def line_of(path: Path) -> str:
    """Return the line of an example: the first sentence of its docstring, and the issues that it names.

    Raises:
        ValueError: It names no issue.
    """
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    issues = [f"[{issue[1]}#{issue[2]}]({issue[0]})" for issue in _ISSUE.finditer(text)]
    if not issues:
        raise ValueError(f"{path}: the docstring names no issue; expected https://github.com/OWNER/NAME/issues/NUMBER")
    what = text.partition("\n\n")[0].replace("\n", " ").removesuffix(".")
    return f"| {what} | {', '.join(issues)} | [{_name(path)}](#{_name(path).replace(' ', '-')}) |\n"


def section_of(path: Path) -> str:
    """Return the section of an example: its code."""
    code = path.read_text(encoding="utf-8")
    return f"\n## {_name(path).capitalize()}\n\n<!-- part of: {path} -->\n```python\n{code}```\n"


def _name(path: Path) -> str:
    return path.stem.removeprefix("test_").replace("_", " ")


if __name__ == "__main__":
    sys.exit(main())
