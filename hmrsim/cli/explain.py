"""``hmrsim explain``: what a code means, why it comes, and what to do."""

from __future__ import annotations

import argparse
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from hmrsim.cli.columns import columns
from hmrsim.cli.exits import ExitCode, UnknownName
from hmrsim.cli.output import show, show_json
from hmrsim.diagnostics import instead, shown
from hmrsim.explanations import explanations

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.explanations import Explanation

_WIDTH: Final = 100

_EXAMPLES: Final = """\
examples:
  hmrsim explain 208
  hmrsim explain not_ready
  hmrsim explain              # all codes, a line each"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim explain``."""
    parser.description = (
        "Explain a code: the error code of a result, the reason of a rejection, the cause of an aborted goal, the "
        "result of a service (result_4), or the exit code of a command (exit_3)."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("code", metavar="CODE", nargs="?", help="such as 208, -19, not_ready or exit_3 (default: list)")
    parser.add_argument("--json", action="store_true", help="print one JSON object, or a list")
    parser.set_defaults(function=_explain)


def _explain(args: argparse.Namespace) -> int:
    known = explanations()
    if args.code is None:
        if args.json:
            show_json([asdict(each) for each in known.values()])
        else:
            for line in columns([(each.code, each.name, each.means) for each in known.values()]):
                show(line)
        return ExitCode.DONE
    found = known.get(args.code)
    if found is None:
        # A number is not misspelled; an action of a package has its own.
        of_package = "; `hmrsim action info` lists those of an action of a package"
        other = of_package if args.code.lstrip("-").isdigit() else instead(args.code, known)
        raise UnknownName(f"no code {shown(args.code)}{other}; `hmrsim explain` lists all")
    if args.json:
        show_json(asdict(found))
    else:
        show(_text(found))
    return ExitCode.DONE


def _text(found: Explanation) -> str:
    parts = (("Why", found.why), ("What to do", found.do))
    told = [f"{found.code} {found.name} ({found.of})", *textwrap.wrap(found.means, _WIDTH)]
    for title, text in parts:
        told += ["", f"{title}:", *_wrapped(text)]
    return "\n".join(told)


def _wrapped(text: str) -> Iterator[str]:
    """Yield the lines of a text, indented; each of its own lines is a paragraph or an entry of a list, or empty."""
    for line in text.splitlines():
        hanging = "    " if line.startswith("- ") else "  "
        yield from textwrap.wrap(line, _WIDTH, initial_indent="  ", subsequent_indent=hanging) or [""]
