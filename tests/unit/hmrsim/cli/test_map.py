"""``hmrsim map``."""

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
    """Return a world file with two errors."""
    path = tmp_path / "broken.yaml"
    path.write_text(BROKEN)
    return path


def test_shipped_world_is_right(capsys):
    """A world without errors ends with 0 and says so."""
    code = main(["map", "validate", "hospital"])

    assert 0 == code
    assert capsys.readouterr().out.endswith("0 errors, 0 warnings\n")


def test_every_error_is_listed_with_file_and_line(broken, capsys):
    """A world with errors ends with 1; each error names file, line and field."""
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
def test_the_policy_of_a_world_that_sets_none(robots, line, tmp_path, capsys):
    """The line before the counts names the policy, and says why it is the default."""
    path = tmp_path / "pair.yaml"
    path.write_text(f"waypoints: {{a: [0, 0], b: [9, 0]}}\nlanes: [[a, b]]\nrobots: {robots}\n")
    code = main(["map", "validate", str(path)])

    assert 0 == code
    assert [line, "0 errors, 0 warnings"] == capsys.readouterr().out.splitlines()


def test_no_policy_is_named_where_no_two_robots_can_meet(capsys):
    """The world has one robot."""
    main(["map", "validate", "scenario1"])

    assert "traffic policy" not in capsys.readouterr().out


def test_errors_as_json(broken, capsys):
    """For programs there is one JSON list."""
    code = main(["map", "validate", str(broken), "--json"])

    problems = json.loads(capsys.readouterr().out)
    assert 1 == code
    assert [
        (2, "lanes.1.to", "error"),
        (3, "robots.wall_e.at", "error"),
    ] == [(one["line"], one["path"], one["severity"]) for one in problems]


def test_warnings_have_their_place(tmp_path, capsys):
    """A world with warnings only ends with 0, and each warning has its place."""
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
def test_a_file_that_cannot_be_read_is_2(content, tmp_path, capsys):
    """A file that is missing or has no known format ends with 2, and is named."""
    path = tmp_path / "world.yaml"
    if content is not None:
        path.write_bytes(content.encode("latin-1"))

    code = main(["map", "validate", str(path)])

    assert 2 == code
    assert capsys.readouterr().out.startswith(str(path))


def test_a_page_that_is_not_there_is_2(capsys):
    """A drawing without the page of ``--page`` can't be read."""
    code = main(["map", "validate", "tests/unit/hmrsim/world/data/ward.drawio", "--page", "3"])

    assert 2 == code
    assert "has no page '3'" in capsys.readouterr().out


def test_what_the_command_line_adds_is_checked(capsys):
    """A robot with a name that is taken is an error, as in the file."""
    code = main(["map", "validate", "hospital", "--robot", "eve@1,2"])

    assert 1 == code
    assert capsys.readouterr().out.startswith("--robot eve@1,2: robots.eve: 'eve' is in ")


def test_a_shipped_world_by_its_file_name(capsys):
    """The error for a shipped world's name with a suffix gives the name."""
    code = main(["map", "validate", "hospital.yaml"])

    assert 2 == code
    assert capsys.readouterr().out.startswith("hospital.yaml: no such file; the shipped world is called 'hospital'\n")


def test_running_a_broken_world_is_2(broken, capsys):
    """`run` rejects a world with errors, and lists them on stderr."""
    code = main(["run", str(broken)])

    captured = capsys.readouterr()
    assert (2, "") == (code, captured.out)
    assert captured.err.startswith(f"{broken}:2: lanes.1.to: ")


@pytest.mark.parametrize("option", [("--robot", "x@"), ("--item", "x@1,2:heavy"), ("--rename", "x")])
def test_an_option_that_cannot_be_read_is_2(option, capsys):
    """It is wrong use of the command line, as for every command that takes a world."""
    code = main(["map", "validate", "hospital", *option])

    assert 2 == code
    assert f"{' '.join(option)}: expected " in capsys.readouterr().out
