"""The command's output about its trees, in a real world in lockstep."""

from __future__ import annotations

import json
import threading
from pathlib import Path

import pytest

from bt_controller.cli import main
from hmrsim_zenoh.wire.session import open_client
from tests.served_world import served_world

FILE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Fallback name="Either">
      <Sequence name="Rest">
        <Wait name="Wait" wait_duration="2.0"/>
        <AlwaysFailure name="No more"/>
      </Sequence>
      <Sequence name="Go">
        <Wait name="Wait" wait_duration="0.5"/>
        <NavigateToPose name="Far away" goal="500;500;0"/>
      </Sequence>
    </Fallback>
  </BehaviorTree>
</root>
"""
RUN = ("run", "tree.xml", "--robot", "wall_e", "eve", "--connect")
WHY = ["No more", "Far away"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Work in a folder with a tree that fails after 2.5 s for two reasons."""
    monkeypatch.chdir(tmp_path)
    Path("tree.xml").write_text(FILE)


def run(*options):
    """Run the tree for two robots; return the exit code."""
    with served_world(clock="lockstep") as session:
        return main([*RUN, *session.connect, *options])


def test_a_failure_is_printed_with_its_reasons(capsys):
    code = run("--quiet")

    out = capsys.readouterr().out
    assert 1 == code
    why = "FAILURE: No more (tree.xml:6); Far away (tree.xml:10)"
    assert [f"wall_e: {why}", f"eve: {why}"] == [
        line.partition(": aborted")[0].partition(": rejected")[0] for line in out.splitlines()
    ]
    assert "outside" in out


def test_json_has_the_reasons_of_failures(capsys):
    run("--json", "--quiet")

    (outcome,) = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert WHY == [each["node"] for each in outcome["reasons"]["eve"]]
    assert ["", True] == [each["message"] and "outside" in each["message"] for each in outcome["reasons"]["eve"]]


def test_two_runs_print_the_same_transitions():
    logs = []
    for _ in range(2):
        run("--quiet", "--transitions", "log.jsonl")
        logs.append(Path("log.jsonl").read_bytes())

    assert logs[0] == logs[1]
    lines = [json.loads(line) for line in logs[0].splitlines()]
    assert [
        (0.0, "Either/Rest/Wait", "RUNNING"),
        (2.0, "Either/Rest/Wait", "SUCCESS"),
        (2.0, "Either/Go/Wait", "RUNNING"),
        (2.5, "Either/Go/Wait", "SUCCESS"),
    ] == [
        (line["sim_time"], line["node"], line["to"])
        for line in lines
        if line["robot"] == "eve" and line["node"].endswith("Wait") and line["to"] != "INVALID"
    ]


def test_watching_trees_does_not_change_the_run():
    run("--quiet", "--transitions", "alone.jsonl")
    over = threading.Event()

    def ask(session):
        while not over.is_set():
            list(session.get("hmrsim/*/_tree"))

    heard = []
    with served_world(clock="lockstep") as options, open_client(options) as session:
        session.declare_subscriber("hmrsim/*/_tree", heard.append)
        watcher = threading.Thread(target=ask, args=(session,))
        watcher.start()
        main([*RUN, *options.connect, "--quiet", "--transitions", "watched.jsonl"])
        over.set()
        watcher.join()

    assert Path("alone.jsonl").read_bytes() == Path("watched.jsonl").read_bytes()
    assert heard


def test_the_trees_can_be_drawn_as_they_ended():
    run("--quiet", "--dot", "end.dot")

    lines = Path("end.dot").read_text().splitlines()
    assert 2 == sum('label="{o} Either"' in line for line in lines)
    assert 2 == sum('label="No more"' in line and "color=red" in line for line in lines)


def test_a_tree_can_be_drawn_without_running_it(capsys):
    code = main(["check", "tree.xml", "--dot", "-"])

    out = capsys.readouterr().out
    assert (0, "digraph {", "}") == (code, out.splitlines()[0], out.splitlines()[-1])
    assert 'label="Far away"' in out


@pytest.mark.parametrize("option", ["--transitions", "--dot"])
def test_an_unwritable_file_is_one_line_with_its_option_and_exits_with_2(option, capsys):
    assert 2 == run("--quiet", option, "nowhere/x")
    assert (
        f"bt-controller: {option} nowhere/x: can't be written: no such file or directory\n" == capsys.readouterr().err
    )


def test_a_picture_that_can_not_be_drawn_fails_before_the_run(monkeypatch, capsys):
    """A mission may take hours."""
    monkeypatch.setenv("PATH", "")

    assert 2 == run("--svg", "end.svg")
    assert ("", True) == ((told := capsys.readouterr()).out, "apt install graphviz" in told.err)
