"""The command ``hmrsim map validate``."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main

BROKEN = """\
waypoints: {a: [0, 0], b: [1, 0]}
lanes: [[a, b], [a, c]]
robots: {wall_e: {at: nowhere}}
"""


@pytest.fixture
def broken(tmp_path):
    path = tmp_path / "broken.yaml"
    path.write_text(BROKEN)
    return path


def test_a_valid_world_exits_with_0(capsys):
    code = main(["map", "validate", "hospital"])

    assert 0 == code
    assert capsys.readouterr().out.endswith("0 errors, 0 warnings\n")


def test_every_error_is_listed_with_file_and_line(broken, capsys):
    code = main(["map", "validate", str(broken)])

    lines = capsys.readouterr().out.splitlines()
    assert 1 == code
    assert lines[0].startswith(f"{broken}:2: lanes.1.to: ")
    assert lines[1].startswith(f"{broken}:3: robots.wall_e.at: ")
    assert "2 errors, 0 warnings" == lines[2]


POINTS = (
    "traffic policy: free (default: robots pass through each other; to change that, give two a radius or set"
    " traffic.policy)"
)


@pytest.mark.parametrize(
    ("robots", "line"),
    [
        (
            "{ann: {at: a, base: {radius: 0.3}}, bob: {at: b, base: {radius: 0.3}}}",
            "traffic policy: planned (default: 2 robots have a radius)",
        ),
        ("{ann: {at: a}, bob: {at: b}}", POINTS),
    ],
    ids=["bodies", "points"],
)
def test_the_default_policy_is_named_with_its_reason(robots, line, tmp_path, capsys):
    path = tmp_path / "pair.yaml"
    path.write_text(f"waypoints: {{a: [0, 0], b: [9, 0]}}\nlanes: [[a, b]]\nrobots: {robots}\n")
    code = main(["map", "validate", str(path)])

    assert 0 == code
    assert [line, "0 errors, 0 warnings"] == capsys.readouterr().out.splitlines()


def test_no_policy_is_named_for_a_single_robot(capsys):
    main(["map", "validate", "scenario1"])

    assert "traffic policy" not in capsys.readouterr().out


def test_json_lists_the_errors(broken, capsys):
    code = main(["map", "validate", str(broken), "--json"])

    problems = json.loads(capsys.readouterr().out)
    assert 1 == code
    assert [(2, "lanes.1.to", "error"), (3, "robots.wall_e.at", "error")] == [
        (one["line"], one["path"], one["severity"]) for one in problems
    ]


def test_warnings_have_their_place(tmp_path, capsys):
    path = tmp_path / "odd.yaml"
    path.write_text("waypoints: {a: [0, 0], b: [1, 0], c: [2, 0]}\nlanes: [[a, b]]\n")

    code = main(["map", "validate", str(path)])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert lines[0].startswith(f"{path}:1: warning: waypoints.c: ")
    assert "0 errors, 1 warning" == lines[-1]


@pytest.mark.parametrize(
    "content", [None, "", "{", "just words", "\xff"], ids=["missing", "empty", "cut", "text", "bytes"]
)
def test_an_unreadable_file_exits_with_2(content, tmp_path, capsys):
    path = tmp_path / "world.yaml"
    if content is not None:
        path.write_bytes(content.encode("latin-1"))

    code = main(["map", "validate", str(path)])

    assert 2 == code
    assert capsys.readouterr().out.startswith(str(path))


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("tests/unit/hmrsim/world/data/ward.drawio", "--page", "3"), 2, "has no page '3'"),
        (("hospital", "--robot", "eve@1,2"), 1, "--robot eve@1,2: robots.eve: 'eve' is in "),
        (("hospital.yaml",), 2, "hospital.yaml: no such file; the shipped world is called 'hospital'\n"),
        (("hospital", "--robot", "x@"), 2, "--robot x@: expected "),
        (("hospital", "--item", "x@1,2:heavy"), 2, "--item x@1,2:heavy: expected "),
        (("hospital", "--rename", "x"), 2, "--rename x: expected "),
    ],
)
def test_invalid_names_and_options_are_errors(words, code, message, capsys):
    assert code == main(["map", "validate", *words])
    assert message in capsys.readouterr().out


def test_run_rejects_a_broken_world(broken, capsys):
    code = main(["run", str(broken)])

    captured = capsys.readouterr()
    assert (2, "") == (code, captured.out)
    assert captured.err.startswith(f"{broken}:2: lanes.1.to: ")
