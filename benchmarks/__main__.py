"""``python -m benchmarks [NAME …] [--quick] [--json FILE] [--write FILE]``: measure, and print tables."""

from __future__ import annotations

import argparse
import importlib
import json
import pkgutil
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console

import benchmarks
from benchmarks import _report


def main(argv: Sequence[str] | None = None) -> None:
    """Run the benchmarks that are named, or all."""
    names = [info.name for info in pkgutil.iter_modules(benchmarks.__path__) if not info.name.startswith("_")]
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Measure, and print tables.")
    parser.add_argument("name", nargs="*", metavar="NAME", help=f"which, of {', '.join(names)}; all by default")
    parser.add_argument("--quick", action="store_true", help="small sizes and short times: does it run at all?")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    parser.add_argument("--write", type=Path, metavar="FILE", help="replace the tables of this document")
    args = parser.parse_args(argv)
    for unknown in set(args.name) - set(names):
        parser.error(f"no benchmark {unknown!r}; there are {', '.join(names)}")
    out, err = Console(), Console(stderr=True)
    out.print(_report.machine(), highlight=False)
    figures = {}
    for name in args.name or names:
        module = importlib.import_module(f"benchmarks.{name}")
        with err.status(f"{name} …"):
            rows = module.run(**module.QUICK) if args.quick else module.run()
        out.print(_report.as_table((module.__doc__ or "").partition("\n")[0], rows))
        figures[name] = [_report.as_json(row) for row in rows]
        if args.write:
            _report.write(args.write, name, f"{datetime.now(UTC):%Y-%m-%d}", rows)
    if args.json:
        args.json.write_text(json.dumps({"machine": _report.machine(), "benchmarks": figures}, indent=2) + "\n")


if __name__ == "__main__":
    main()
