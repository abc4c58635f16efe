"""An experiment that is killed at any instant, again and again: no run is lost, and none is made twice.

::

    python -m tests.torture.experiments --tries 100

Each try runs an experiment in a process that is killed with SIGKILL after a random time, and started again, until it
is done; then its table is compared with that of an undisturbed run.
"""

from __future__ import annotations

import argparse
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

EXPERIMENT = """\
name: killed
world: zoo/crossing
factors: {speed: [0.5, 1.0, 1.5]}
treatments:
  go: {python: "controller.py:go"}
replications: {min: 20, max: 60, until: {measure: time, relative_error: 0.02}}
overlay: {"robots.*.base.speed": $speed, "lanes.*.speed_factor": {uniform: {low: 0.3, high: 1}}}
measures: {time: end.at}
keep: {traces: all}
"""

CONTROLLER = """\
from hmrsim_zenoh.client.commander import Commander

def go(client):
    robot = client.info()["robots"][0]["name"]
    Commander(client, robot).go_to_pose(10.0, 0.0)
"""


def table(folder: Path) -> list[tuple[object, ...]]:
    """Return all rows without their wall times."""
    with closing(sqlite3.connect(folder / "results.sqlite")) as database:
        columns = [row[1] for row in database.execute("PRAGMA table_info(runs)") if row[1] != "wall"]
        names = ", ".join(f'"{column}"' for column in columns)
        return database.execute(f"SELECT {names} FROM runs ORDER BY number").fetchall()


def start(home: Path, folder: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "hmrsim.cli", "experiment", "run", "killed.yaml", "-o", str(folder)]
    return subprocess.Popen(command, cwd=home, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main() -> int:
    """Run the tries; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    chance = random.Random(args.seed)
    kills = flaws = 0
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        (home / "killed.yaml").write_text(EXPERIMENT)
        (home / "controller.py").write_text(CONTROLLER)
        begun = time.monotonic()
        if start(home, home / "whole").wait():
            sys.stdout.write("the experiment itself fails\n")
            return 1
        takes, whole = time.monotonic() - begun, table(home / "whole")
        traces = {path.name: path.read_bytes() for path in (home / "whole" / "traces").iterdir()}
        for number in range(args.tries):
            folder = home / f"try_{number}"
            while True:
                process = start(home, folder)
                try:
                    process.wait(chance.uniform(0.05, takes))
                    break
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGKILL)
                    process.wait()
                    kills += 1
            found = table(folder)
            kept = {path.name: path.read_bytes() for path in (folder / "traces").iterdir()}
            if process.returncode or found != whole or kept != traces:
                flaws += 1
                said = f"{len(found)} rows of {len(whole)}, {len(kept)} traces"
                sys.stdout.write(f"try {number}: exit code {process.returncode}, {said}\n")
    sys.stdout.write(f"{args.tries} tries, {kills} kills, {len(whole)} runs each: {flaws} flaws\n")
    return 1 if flaws else 0


if __name__ == "__main__":
    sys.exit(main())
