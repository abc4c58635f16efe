"""The files that commands read and write."""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import bt_controller.cli
from hmrsim.cli import main, make_parser
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.store import Results
from tests.parsers import parsers_of

COMMANDS = [
    "hmrsim simulate {}",
    "hmrsim run {}",
    "hmrsim run scenario1 --settings {}",
    "hmrsim run scenario1 --zenoh-config {}",
    "hmrsim replay {}",
    "hmrsim report {}",
    "hmrsim view {}",
    "hmrsim map info {}",
    "hmrsim map convert {} out.yaml",
    "hmrsim map render {} -o out.svg",
    "bt-controller check {}",
    "bt-controller check {}.xml",
]

PROGRAMS = {"hmrsim": main, "bt-controller": bt_controller.cli.main}


def _pipe() -> str:
    os.mkfifo("pipe")
    os.mkfifo("pipe.xml")
    return "pipe"


def _folder() -> str:
    Path("folder").mkdir()
    Path("folder.xml").mkdir()
    return "folder"


def _device() -> str:
    Path("device").symlink_to("/dev/zero")
    Path("device.xml").symlink_to("/dev/zero")
    return "device"


def _round() -> str:
    Path("round").symlink_to("round")
    Path("round.xml").symlink_to("round.xml")
    return "round"


@pytest.mark.parametrize("make", [_pipe, _folder, _device, _round, lambda: "none", lambda: "x" * 5000])
def test_unreadable_inputs_are_errors(tmp_path, monkeypatch, capsys, make: Callable[[], str]):
    monkeypatch.chdir(tmp_path)
    name = make()
    for command in COMMANDS:
        program, *arguments = command.format(name).split()
        code = PROGRAMS[program](arguments)
        output = capsys.readouterr()

        assert (2, 1, "") == (code, output.err.count("\n"), output.out), (command, output.err)
        assert "Traceback" not in output.err


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('{"a":' * 100_000 + "1" + "}" * 100_000, "nested deeper than 50"),
        ('{"mode": "' + "x" * 2_000_000 + '"}', "larger than 1048576 bytes"),
    ],
)
def test_a_hostile_zenoh_configuration_is_an_error(tmp_path, capsys, text, why):
    """Zenoh's parser would crash the process or take a long time."""
    file = tmp_path / "zenoh.json5"
    file.write_text(text)

    assert 2 == main(["topic", "list", "--zenoh-config", str(file)])
    assert f"hmrsim: {file}: not a Zenoh configuration: {why}\n" == capsys.readouterr().err


WORLD = """\
include: [more.yaml]
waypoints: {a: {at: [0, 0]}, b: {at: [4, 0]}}
lanes: [[a, b]]
robots: {wall_e: {at: a, script: [Go b]}}
"""

TREE = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <include path="more.xml"/>
  <BehaviorTree ID="Main"><SubTree ID="More"/></BehaviorTree>
</root>
"""
MORE = '<root BTCPP_format="4"><BehaviorTree ID="More"><AlwaysSuccess/></BehaviorTree></root>'

MODULE = "import py_trees\n\ndef tree():\n    return py_trees.behaviours.Success('fine')\n"

EXPERIMENT = "name: e\nworld: w.yaml\ntreatments: {a: {tree: 'a_tree.py:tree'}}\n"


CASES = [
    ("hmrsim simulate w.yaml --trace {}", "w.yaml"),
    ("hmrsim simulate w.yaml --trace {}", "more.yaml"),
    ("hmrsim simulate w.yaml --overlay over.yaml --trace {}", "over.yaml"),
    ("hmrsim simulate w.yaml --overlay over.yaml --trace {}", "levels.csv"),
    ("hmrsim run w.yaml --trace {}", "w.yaml"),
    ("hmrsim run w.yaml --record {}", "more.yaml"),
    ("hmrsim run w.yaml --settings settings.yaml --trace {}", "settings.yaml"),
    ("hmrsim run w.yaml --zenoh-config zenoh.json5 --record {}", "zenoh.json5"),
    ("hmrsim record {} --zenoh-config zenoh.json5", "zenoh.json5"),
    ("hmrsim map convert w.yaml {} --to yaml --force", "w.yaml"),
    ("hmrsim map convert w.yaml {} --to yaml --force", "more.yaml"),
    ("hmrsim map render w.yaml --output {}", "w.yaml"),
    ("hmrsim report run.jsonl --output {}", "run.jsonl"),
    ("hmrsim experiment report results --output {}", "results/results.sqlite"),
    ("hmrsim experiment export results --output {}", "results/results.sqlite"),
    ("hmrsim experiment again results 0 --trace {}", "e.yaml"),
    ("hmrsim experiment again results 0 --report {}", "results/results.sqlite"),
    ("hmrsim experiment again results 0 --record {}", "results/results.sqlite"),
    ("hmrsim experiment again results 0 --page {}", "results/results.sqlite"),
    ("hmrsim check --repro repro.yaml --record {}", "repro.yaml"),
    ("hmrsim check --repro repro.yaml --page {}", "repro.yaml"),
    ("bt-controller check tree.xml --dot {}", "tree.xml"),
    ("bt-controller check tree.xml --svg {}", "more.xml"),
    ("bt-controller check a_tree:tree --dot {}", "a_tree.py"),
    ("bt-controller run tree.xml --robot wall_e --svg {}", "tree.xml"),
    ("bt-controller run tree.xml --robot wall_e --zenoh-config zenoh.json5 --transitions {}", "zenoh.json5"),
    ("bt-controller run tree.xml --robot wall_e --coverage {}", "tree.xml"),
    ("bt-controller coverage seen.json --output {}", "seen.json"),
]

TWICE = [
    "hmrsim run w.yaml --trace out --record ./out",
    "hmrsim report run.jsonl -o tables/goals.csv --csv tables",
    "bt-controller check tree.xml --dot out --svg out",
    "bt-controller run tree.xml --robot wall_e --dot out --transitions out",
]

FULL = [
    "hmrsim simulate w.yaml --trace /dev/full",
    "hmrsim report run.jsonl -o /dev/full",
    "bt-controller check tree.xml --dot /dev/full",
]


def _symbolic(path: Path) -> str:
    Path("link.svg").symlink_to(path)
    return "link.svg"


def _hard(path: Path) -> str:
    Path("hard.svg").hardlink_to(path)
    return "hard.svg"


WAYS: list[Callable[[Path], str]] = [
    str,
    lambda path: str(path.absolute()),
    lambda path: f"../{Path.cwd().name}/{path}",
    _symbolic,
    _hard,
]


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    texts = {"w.yaml": WORLD, "more.yaml": "places: {p: {at: [1, 1]}}\n", "a_tree.py": MODULE}
    texts |= {"tree.xml": TREE, "more.xml": MORE, "settings.yaml": "seed: 3\n", "zenoh.json5": "{}"}
    texts |= {"over.yaml": "tables: {levels: levels.csv}\nseed: 3\n", "levels.csv": "a,b\n"}
    texts["seen.json"] = '{"format": "hmrsim tree coverage 1", "trees": {}}'
    texts |= {"e.yaml": EXPERIMENT, "repro.yaml": "repro: 1\n"}
    for name, text in texts.items():
        Path(name).write_text(text)
    Results.create(Path("results"), read_plan("e.yaml")).__exit__()
    main(["simulate", "w.yaml", "--trace", "run.jsonl"])
    shutil.copy("run.jsonl", "goals.csv")
    return tmp_path


@pytest.fixture
def said(files, capsys):
    def told(line: str) -> tuple[int, list[str], dict[str, bytes]]:
        before = _contents(files)
        capsys.readouterr()
        program, *arguments = line.split()
        code = PROGRAMS[program](arguments)
        changed = {name: content for name, content in _contents(files).items() if before.get(name) != content}
        return code, capsys.readouterr().err.splitlines(), changed

    return told


def _contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.parametrize(("line", "name"), CASES)
def test_no_input_is_overwritten(said, line, name):
    if "run" in line and "--svg" in line and shutil.which("dot") is None:
        pytest.skip("Graphviz's dot is not installed")
    for way in WAYS if "map render" not in line else WAYS[-2:]:
        code, lines, changed = said(line.format(way(Path(name))))

        assert (2, 1, {}) == (code, len(lines), changed), lines
        assert "this command reads that file" in lines[0]


def test_no_csv_table_overwrites_an_input(said):
    code, lines, changed = said("hmrsim report goals.csv --csv .")

    assert (2, ["hmrsim: --csv goals.csv: this command reads that file; name another"], {}) == (code, lines, changed)


@pytest.mark.parametrize("line", TWICE)
def test_two_outputs_can_not_be_one_file(said, line):
    code, lines, changed = said(line)

    assert (2, 1, {}) == (code, len(lines), changed), lines
    assert "name two files" in lines[0]


@pytest.mark.parametrize("line", FULL)
def test_a_full_disk_is_an_error_of_one_line(said, line):
    code, lines, _ = said(line)

    assert (1, 1) == (code, len(lines)), lines
    assert "/dev/full: can't be written: no space left on device" in lines[0]


@pytest.mark.usefixtures("files")
def test_a_trace_cut_off_by_a_full_disk_is_readable(said, capsys):
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, limits[1]))
    try:
        code, lines, _ = said("hmrsim simulate warehouse --trace cut.jsonl")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (1, ["hmrsim: --trace cut.jsonl: can't be written: file too large"]) == (code, lines[1:])

    assert (0, 0) == (main(["replay", "cut.jsonl"]), main(["report", "cut.jsonl"]))
    assert "the trace is truncated there" in capsys.readouterr().out


def test_two_outputs_may_both_be_dev_null(said):
    code, lines, _ = said("hmrsim run w.yaml --trace /dev/null --record /dev/null --connect tcp/127.0.0.1:9")

    assert (3, False) == (code, "name two files" in lines[0])


INPUTS = {
    "--allow-files",
    "--folder",
    "--monitor",
    "--overlay",
    "--properties",
    "--repro",
    "--secure",
    "--settings",
    "--zenoh-config",
    "DIR",
    "FILE",
    "TRACE|MCAP",
    "RECORDING.mcap",
}


def test_each_output_is_tried():
    """The demo is exempt, because its world is shipped.

    Keystores and folders of results are exempt, because their commands change only their own files.
    """
    lines = [*(line for line, _ in CASES), *TWICE]
    outputs = {
        (parser.prog, option)
        for program in (make_parser(), bt_controller.cli.make_parser())
        for parser in parsers_of(program)
        for action in parser._actions
        if any(word in str(action.metavar) for word in ("FILE", "DIR", "OUT", "MCAP", "mcap"))
        for option in [action.option_strings[-1] if action.option_strings else str(action.metavar)]
        if option not in INPUTS and not parser.prog.startswith("hmrsim security ")
    }

    folders = {("hmrsim experiment run", "--output"), ("hmrsim check", "--output")}
    assert {("hmrsim demo", "--trace"), ("hmrsim demo", "--record"), *folders} == {
        (command, option)
        for command, option in outputs
        if not any(
            line.startswith(f"{command} ") and (option in line or (option[0] != "-" and " {}" in line))
            for line in lines
        )
    }


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("run scenario1 --record run.jsonl", "--record run.jsonl: a recording is no .jsonl file; expected a name that"),
        ("run scenario1 --trace run.mcap", "--trace run.mcap: a trace is no .mcap file; expected a name that ends in"),
        (
            "simulate warehouse --trace run.yaml",
            "--trace run.yaml: a trace is no .yaml file; expected a name that ends",
        ),
        ("demo --record demo.html", "--record demo.html: a recording is no .html file; expected a name that ends in"),
    ],
)
def test_an_output_with_the_suffix_of_another_format_is_rejected(line, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    assert 2 == main(line.split())
    assert message in capsys.readouterr().err
    assert [] == [*tmp_path.iterdir()]
