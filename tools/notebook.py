"""Writes the notebook of the docs from its page, with the output of each cell.

Run as ``python -m tools.notebook [--check]``; docs/how_to/notebook.ipynb is generated from docs/how_to/notebook.md, and
the code of the page is executed for that.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import io
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from markdown_it import MarkdownIt

_PAGE: Final = Path("docs/how_to/notebook.md")
_FILE: Final = _PAGE.with_suffix(".ipynb")
_HEAD: Final = {"nbformat": 4, "nbformat_minor": 5}
_KERNEL: Final = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}


def main(argv: Sequence[str] | None = None) -> int:
    """Write the notebook, or report that it is out of date."""
    parser = argparse.ArgumentParser(prog="python -m tools.notebook", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if something is wrong")
    arguments = parser.parse_args(argv)
    cells = [{**cell, "id": f"cell-{number}"} for number, cell in enumerate(_cells(_PAGE.read_text(encoding="utf-8")))]
    new = json.dumps({"cells": cells, "metadata": _KERNEL, **_HEAD}, indent=1, ensure_ascii=False) + "\n"
    if arguments.check and (not _FILE.exists() or _FILE.read_text(encoding="utf-8") != new):
        sys.stderr.write(f"{_FILE}: out of date; run make schemas\n")
        return 1
    if not arguments.check:
        _FILE.write_text(new, encoding="utf-8")
    return 0


def _cells(page: str) -> Iterator[dict[str, Any]]:
    """Yield the cells: text up to a block of Python, and the block, without the output that the page shows."""
    lines = page.splitlines()
    names: dict[str, Any] = {}
    begin, count = 0, 0
    for token in MarkdownIt().parse(page):
        if token.type not in {"fence", "html_block"} or token.map is None:
            continue
        start, end = token.map
        yield from _text(lines[begin:start])
        begin = end
        if token.type == "fence" and token.info.split()[:1] == ["python"]:
            count += 1
            outputs = list(_run(token.content, names, count))
            source = token.content.rstrip("\n").splitlines(keepends=True)
            yield {"cell_type": "code", "execution_count": count, "metadata": {}, "outputs": outputs, "source": source}
    yield from _text(lines[begin:])


def _text(lines: list[str]) -> Iterator[dict[str, Any]]:
    text = "\n".join(lines).strip()
    if text:
        yield {"cell_type": "markdown", "metadata": {}, "source": text.splitlines(keepends=True)}


def _run(code: str, names: dict[str, Any], count: int) -> Iterator[dict[str, Any]]:
    """Yield the printed output of a cell, and the representation of its last expression."""
    body = ast.parse(code).body
    last = body[-1] if isinstance(body[-1], ast.Expr) else None
    body = body[:-1] if last else body
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(ast.Module(body, []), "cell", "exec"), names)  # noqa: S102 - it is our own page
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None  # noqa: S307
    if printed.getvalue():
        yield {"name": "stdout", "output_type": "stream", "text": printed.getvalue().splitlines(keepends=True)}
    for kind, method in (("image/svg+xml", "_repr_svg_"), ("text/html", "_repr_html_")):
        if hasattr(value, method):
            data = {kind: getattr(value, method)().splitlines(keepends=True), "text/plain": [type(value).__name__]}
            yield {"data": data, "execution_count": count, "metadata": {}, "output_type": "execute_result"}


if __name__ == "__main__":
    sys.exit(main())
