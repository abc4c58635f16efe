"""``hmrsim explain``: the meaning of a code, its causes, and what to do."""

from __future__ import annotations

import argparse
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode, UnknownName
from hmrsim.cli.output import columns, show_result
from hmrsim.diagnostics import instead, shown

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.explanations import Explanation

_WIDTH: Final = 100

_EXAMPLES: Final = """\
examples:
  hmrsim explain 208
  hmrsim explain not_ready
  hmrsim explain              # all codes, one per line"""


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
    from hmrsim.explanations import explanations

    known = explanations()
    if args.code is None:
        rows = [(each.code, each.name, each.means) for each in known.values()]
        show_result([asdict(each) for each in known.values()], columns(rows), as_json=args.json)
        return ExitCode.DONE
    explanation = known.get(args.code)
    if explanation is None:
        # Numbers are not misspelled, but may be defined by an action of another package.
        of_package = "; `hmrsim action info` lists those of an action of a package"
        other = of_package if args.code.lstrip("-").isdigit() else instead(args.code, known)
        raise UnknownName(f"no code {shown(args.code)}{other}; `hmrsim explain` lists all")
    show_result(asdict(explanation), _lines(explanation), as_json=args.json)
    return ExitCode.DONE


def _lines(explanation: Explanation) -> Iterator[str]:
    yield f"{explanation.code} {explanation.name} ({explanation.of})"
    yield from textwrap.wrap(explanation.means, _WIDTH)
    for title, text in (("Why", explanation.why), ("What to do", explanation.do)):
        yield from ("", f"{title}:", *_wrapped(text))


def _wrapped(text: str) -> Iterator[str]:
    """Yield the wrapped and indented lines of a text; each line of it is a paragraph, an entry of a list, or empty."""
    for line in text.splitlines():
        hanging = "    " if line.startswith("- ") else "  "
        yield from textwrap.wrap(line, _WIDTH, initial_indent="  ", subsequent_indent=hanging) or [""]
