"""Write, compare or pin the golden runs: ``python -m tests.golden --help``."""

# ruff: noqa: T201 - printing is what a command does

from __future__ import annotations

import argparse
import json
import sys
from itertools import zip_longest
from pathlib import Path

from tests.golden import _cases

_SHOWN = 200
"""Characters of a line that are shown, around where two lines part."""

_EXAMPLES = """\
examples:
  python -m tests.golden /tmp/before                      # on the commit before a change
  python -m tests.golden /tmp/after --against /tmp/before # on the commit after it
  python -m tests.golden --update                         # pin what was changed on purpose"""


def main():
    """Run the cases; return 1 if any has changed."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.golden", epilog=_EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.description = "Run all golden cases; say which are not as pinned."
    parser.add_argument("directory", nargs="?", type=Path, help="write traces, reports and scenes there")
    parser.add_argument("--against", type=Path, metavar="DIR", help="show the first line that differs from there")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose name contains it")
    parser.add_argument("--update", action="store_true", help="pin what comes out")
    args = parser.parse_args()
    pinned = _cases.known() if _cases.HASHES.exists() else {}
    found, changed = {}, []
    for name in (name for name in _cases.CASES if args.only in name):
        texts = _cases.made(name)
        found[name] = _cases.digests(texts)
        if args.directory:
            _write(args.directory / name, texts)
        if found[name] != pinned.get(name):
            changed.append(name)
            print(f"{name}: not as pinned")
        if args.against:
            _show(name, args.against / name, texts)
    print(f"{len(found)} cases, {len(changed)} not as pinned")
    if args.update:
        kept = {name: digest for name, digest in pinned.items() if name in _cases.CASES}
        _cases.HASHES.write_text(json.dumps(kept | found, indent=1, sort_keys=True) + "\n")
        return 0
    return 1 if changed else 0


def _write(folder, texts):
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text)


def _show(case, folder, texts):
    """Print the first changed line of each text."""
    for name, text in texts.items():
        path = folder / name
        before = path.read_text().splitlines() if path.exists() else []
        pairs = zip_longest(before, text.splitlines(), fillvalue="(ends)")
        for number, (old, new) in enumerate(pairs, start=1):
            if old != new:
                at = next((i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), 0)
                shown = slice(max(0, at - _SHOWN // 2), at + _SHOWN // 2)
                print(f"{case}/{name}:{number}, character {at}\n  before: {old[shown]}\n  now:    {new[shown]}")
                break


if __name__ == "__main__":
    sys.exit(main())
