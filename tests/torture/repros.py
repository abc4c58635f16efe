"""Failures that are repeated from their files: in another folder, under another hash seed, on a busy machine.

::

    python -m tests.torture.repros --tries 100 --only hidden_failure occupied_berth
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.results_folder import ResultsFolder
from hmrsim.trials.batches import factory_of
from tests.torture.planted import catalogue, check_of, say, searched

_BUSY = "while True: pass"


def repeated(path: Path, folder: Path, seed: int) -> str:
    """Return the differences of a failure that is repeated, if any."""
    environment = {**os.environ, "PYTHONHASHSEED": str(seed)}
    command = [sys.executable, "-m", "hmrsim.cli", "check", "--repro", str(path), "--json"]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 1:
        return f"exit code {done.returncode}: {done.stdout[-300:]}{done.stderr[-300:]}"
    said = json.loads(done.stdout)
    return (
        ""
        if said["same_failure"] and said["same_trace"] is not False
        else f"{said['ending']} at {said['at']}: {said['violations']}"
    )


def main() -> int:
    """Repeat failures; return 1 if one ended differently."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tries", type=int, default=100)
    parser.add_argument("--only", nargs="+", default=[], help="these bugs only")
    args = parser.parse_args()
    rng = random.Random(1)
    make, workers = factory_of("pool", 2)
    entries = {name: entry for name, entry in catalogue().items() if not args.only or name in args.only}
    flaws = tries = 0
    with tempfile.TemporaryDirectory() as name:
        paths = {}
        with Evaluator(check_of(next(iter(entries.values())), "bug"), make, workers) as evaluator:
            for bug, entry in entries.items():
                check = check_of(entry, "bug", budget="5m")
                summary = searched(check, evaluator)
                if summary.findings:
                    paths[bug] = ResultsFolder(Path(name) / bug).keep(check, summary.findings[0])
        with subprocess.Popen([sys.executable, "-c", _BUSY]) as busy, ThreadPoolExecutor(2) as threads:
            for bug, path in paths.items():
                folders = [Path(tempfile.mkdtemp(dir=name)) for _ in range(args.tries)]
                seeds = [rng.randrange(2**32) for _ in folders]
                said = [*threads.map(lambda folder, seed, path=path: repeated(path, folder, seed), folders, seeds)]
                different = [each for each in said if each]
                tries, flaws = tries + len(said), flaws + len(different)
                say(f"{bug:32} {len(said)} tries, {len(different)} came out otherwise {different[:1]}")
            busy.kill()
    say(f"{flaws} of {tries} tries came out otherwise")
    return int(flaws > 0)


if __name__ == "__main__":
    sys.exit(main())
