"""The options that the commands of ``hmrsim experiment`` have in common."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_file(parser: argparse.ArgumentParser) -> None:
    """Add the file of an experiment, and its variants."""
    parser.add_argument("file", metavar="FILE", help="the file of an experiment, YAML or JSON")
    parser.add_argument(
        "--variant", action="append", default=[], metavar="NAME", help="lay a variant of the file over it; repeatable"
    )


def add_results(parser: argparse.ArgumentParser) -> None:
    """Add the folder of results."""
    parser.add_argument("results", metavar="DIR", type=Path, help="the folder of an experiment's results")
