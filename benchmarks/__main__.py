"""Run every benchmark and print its table."""

from __future__ import annotations

import importlib
import pkgutil

from rich.console import Console
from rich.table import Table

import benchmarks


def main() -> None:
    """Run each module of this folder that has a *run* function."""
    console = Console()
    for info in pkgutil.iter_modules(benchmarks.__path__):
        if info.name.startswith("_"):
            continue
        module = importlib.import_module(f"benchmarks.{info.name}")
        table = Table(*["what", "median", "against bare"], title=(module.__doc__ or "").partition("\n")[0])
        for row in module.run():
            table.add_row(*row)
        console.print(table)


if __name__ == "__main__":
    main()
