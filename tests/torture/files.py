"""Damage files at random, and have the commands read them: `python -m tests.torture.files --help`.

Each case is a file, changed by a seed and its number, and a command that reads it in a worker process.
It is a finding if the command raises anything, takes too long or too much memory, writes more than a screen of text,
or writes control characters to the terminal.
"""

# ruff: noqa: T201 - printing is what a command does

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import importlib
import io
import multiprocessing
import os
import re
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Final

import bt_controller.cli
from hmrsim.cli import main as hmrsim
from hmrsim.cli.replay import lines_of
from hmrsim.cli.worlds import show_findings
from hmrsim.errors import HmrsimError, printable
from hmrsim.properties import Monitor, check_properties, check_recording, check_trace, properties_of, read_properties
from hmrsim.settings.run import read_file
from hmrsim.world_checks import load_world
from hmrsim_zenoh.recording import Recording
from hmrsim_zenoh.settings import SERVED
from tests.torture.corpus import Sample, samples
from tests.torture.mutation import mutated, mutated_lines

if TYPE_CHECKING:
    from types import FrameType

MAX_SECONDS: Final = 10.0
MAX_MEGABYTES: Final = 300.0
"""Of each case, beyond what its process has before it."""

_BATCH: Final = 250
_MAX_TEXT: Final = 200_000
"""Characters that a command may write about a file that it refuses."""
_CODES: Final = (0, 1, 2)
_CONTROL: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


@dataclass(frozen=True)
class Finding:
    """A case that went wrong.

    Attributes:
        what: In one line.
        details: A traceback, or what the command wrote.
    """

    number: int
    command: str
    what: str
    details: str


class _TooLong(BaseException):
    """Raised when a case takes too long."""


def _read_settings(path: str) -> int:
    """Read a settings file as ``hmrsim run --settings`` does."""
    try:
        read_file(Path(path), SERVED)
    except HmrsimError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _watched(path: str) -> int:
    """Read properties like ``hmrsim run --monitor``, and check their names in a world."""
    try:
        properties = read_properties(path)
        Monitor(properties, world := load_world("hospital").world)
        show_findings(properties, check_properties(properties, world))
    except HmrsimError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _checked(path: str) -> int:
    """Check the properties of a run like a check of a trace or a recording."""
    # Robots that are in all worlds of the corpus, and places that are in none, so that events have something to hit.
    said = {"x": {"whenever": {"event": "status"}, "then": {"robot": "$robot", "is": "idle"}, "within": 5}}
    properties = properties_of({"properties": {**said, "y": {"never": {"battery": "*", "below": 0.5}}}})
    try:
        file = Path(path).read_bytes()[:8]
        if file.startswith(b"\x89MCAP"):
            checked = check_recording(Recording(Path(path)), properties)
        else:
            checked = check_trace(lambda: lines_of(Path(path)), properties)
        checked.monitor.verdicts()
    except (HmrsimError, OSError, UnicodeDecodeError) as error:
        print(printable(str(error)), file=sys.stderr)
        return 2
    return 0


def _played(path: str) -> int:
    """Read a recording like ``hmrsim view``."""
    # Loads what serves pages.
    from hmrsim_zenoh.view.sources import Recorded  # noqa: PLC0415

    try:
        Recorded(Recording(Path(path)))
    except HmrsimError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


_COMMANDS: Final[dict[str, tuple[tuple[str, Callable[[str], int], float], ...]]] = {
    "world": (
        ("hmrsim simulate {} --duration 5", lambda path: hmrsim(["simulate", path, "--duration", "5"]), 0.7),
        ("hmrsim map info {}", lambda path: hmrsim(["map", "info", path]), 0.1),
        ("hmrsim map render {}", lambda path: hmrsim(["map", "render", path]), 0.1),
        ("hmrsim map convert {} -", lambda path: hmrsim(["map", "convert", path, "-"]), 0.1),
    ),
    "tree": (("bt-controller check {}", lambda path: bt_controller.cli.main(["check", path]), 1.0),),
    "coverage": (("bt-controller coverage {}", lambda path: bt_controller.cli.main(["coverage", path]), 1.0),),
    "trace": (
        ("hmrsim replay {}", lambda path: hmrsim(["replay", path]), 0.5),
        ("hmrsim report {} --json", lambda path: hmrsim(["report", path, "--json"]), 0.3),
        ("check_trace({})", _checked, 0.2),
    ),
    "recording": (
        ("hmrsim report {} --json", lambda path: hmrsim(["report", path, "--json"]), 0.4),
        ("hmrsim view {}", _played, 0.4),
        ("check_recording({})", _checked, 0.2),
    ),
    "settings": (("hmrsim run --settings {}", _read_settings, 1.0),),
    "properties": (("hmrsim run --monitor {}", _watched, 1.0),),
}
"""What reads each kind of file, and how often."""


@dataclass(frozen=True)
class Case:
    """A damaged file, and the command to read it."""

    number: int
    sample: Sample
    content: bytes
    command: str
    run: Callable[[str], int]


def case(seed: int, number: int, kinds: tuple[str, ...] = ()) -> Case:
    """Return a case; the same for the same seed and number."""
    random = Random(f"{seed}:{number}")
    kind = random.choice(kinds or tuple(_COMMANDS))
    own = [sample for sample in samples() if sample.kind == kind]
    # Smaller files more often: they are read sooner, and a change hits what matters.
    sample = own[min(int(random.expovariate(2.5) * len(own)), len(own) - 1)]
    other = random.choice(own).content
    if kind == "trace" and random.random() < 0.8:
        content = mutated_lines(sample.content.splitlines(keepends=True), random, other)
    else:
        content = mutated(sample.content, random, other)
    readers = _COMMANDS[kind]
    command, run, _ = random.choices(readers, [share for _, _, share in readers])[0]
    return Case(number, sample, content, command, run)


def tried(one: Case, folder: Path) -> Finding | None:
    """Read a damaged file, and return the problem, if any."""
    path = folder / one.sample.name
    path.write_bytes(one.content)
    out, err = io.StringIO(), io.StringIO()
    before = _peak(reset=True)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), _alarm():
            code = one.run(str(path))
    except _TooLong:
        return Finding(one.number, one.command, f"takes longer than {MAX_SECONDS:g} s", traceback.format_exc(limit=-25))
    except BaseException as error:  # noqa: BLE001 - which is what is looked for
        what = f"{type(error).__name__}: {str(error)[:200]}"
        return Finding(one.number, one.command, what, "".join(traceback.format_exception(error, limit=-15)))
    used = _peak() - before
    what = f"takes {used:.0f} MB" if used > MAX_MEGABYTES else _wrong(code, out.getvalue(), err.getvalue())
    return Finding(one.number, one.command, what, ascii(err.getvalue())[:2_000]) if what else None


def _wrong(code: int, out: str, err: str) -> str:
    """Return the problem with a command's end, or nothing."""
    wrong = {
        f"exit code {code}": code not in _CODES,
        "exit code 2 without a word": code == _CODES[-1] and not (err + out).strip(),
        f"an error of {len(err)} characters": len(err) > _MAX_TEXT,
        "control characters in an error": any(not (c.isprintable() or c == "\n") for c in err),
        "control characters in the output": bool(_CONTROL.search(out)),
    }
    return next((what for what, is_so in wrong.items() if is_so), "")


@contextlib.contextmanager
def _alarm() -> Iterator[None]:
    def ring(_number: int, _frame: FrameType | None) -> None:
        raise _TooLong

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, MAX_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _peak(*, reset: bool = False) -> float:
    """Return the peak memory of this process since the last reset, in MB."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5", "ascii")
    lines = Path("/proc/self/status").read_text("ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:")) / 1024


def _worker(seed: int, numbers: range, kinds: tuple[str, ...], queue: multiprocessing.SimpleQueue[object]) -> None:
    faulthandler.enable()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for number in numbers:
            queue.put(number)
            finding = tried(case(seed, number, kinds), Path(folder))
            if finding is not None:
                queue.put(finding)
    queue.put(None)


def findings(seed: int, count: int, kinds: tuple[str, ...] = (), begin: int = 0) -> Iterator[Finding]:
    """Try cases in processes, one after the other, and yield the findings."""
    samples()
    # Loaded once for all processes: on a busy machine it takes longer than a case may.
    importlib.import_module("hmrsim.cli.map_info")
    context = multiprocessing.get_context("fork")
    number = begin
    while number < begin + count:
        numbers = range(number, min(number + _BATCH, begin + count))
        queue = context.SimpleQueue()
        worker = context.Process(target=_worker, args=(seed, numbers, kinds, queue))
        worker.start()
        number = yield from _heard(worker, queue, numbers, seed, kinds)


def _heard(
    worker: multiprocessing.process.BaseProcess,
    queue: multiprocessing.SimpleQueue[object],
    numbers: range,
    seed: int,
    kinds: tuple[str, ...],
) -> Generator[Finding, None, int]:
    """Yield the findings of a process; return the number of the next case."""
    last = numbers.start
    while True:
        since = time.monotonic()
        while queue.empty() and worker.is_alive() and time.monotonic() - since < MAX_SECONDS * 3:
            time.sleep(0.01)
        if queue.empty():
            hung = worker.is_alive()
            worker.kill()
            worker.join()
            what = "hangs where no signal reaches it" if hung else f"ends its process with {worker.exitcode}"
            yield Finding(last, case(seed, last, kinds).command, what, "")
            return last + 1
        match queue.get():
            case int() as last:
                pass
            case Finding() as finding:
                yield finding
            case None:
                worker.join()
                return numbers.stop


def main() -> int:
    """Run cases and print the findings; return 1 if there are any."""
    parser = argparse.ArgumentParser(prog="python -m tests.torture.files", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=1000, help="cases (1000)")
    parser.add_argument("--seed", type=int, default=0, help="what the changes depend on (0)")
    parser.add_argument("--begin", type=int, default=0, help="number of the first case (0)")
    parser.add_argument("--kind", action="append", default=[], choices=sorted(_COMMANDS), help="repeatable (all)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="write the files that were found there")
    parser.add_argument("--verbose", action="store_true", help="print tracebacks")
    args = parser.parse_args()
    kinds, seen, began = tuple(args.kind), Counter[str](), time.monotonic()
    for finding in findings(args.seed, args.count, kinds, args.begin):
        seen[finding.what] += 1
        one = case(args.seed, finding.number, kinds)
        print(f"{finding.number}: {finding.command.format(one.sample.name)}: {finding.what}", flush=True)
        if args.verbose and seen[finding.what] == 1:
            print(finding.details, flush=True)
        if args.keep is not None:
            args.keep.mkdir(parents=True, exist_ok=True)
            (args.keep / f"{args.seed}-{finding.number}-{one.sample.name}").write_bytes(one.content)
    seconds = time.monotonic() - began
    print(f"{args.count} cases in {seconds:.0f} s, {sum(seen.values())} findings")
    return 1 if seen else 0


if __name__ == "__main__":
    sys.exit(main())
