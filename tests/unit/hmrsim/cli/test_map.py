"""The command ``hmrsim map validate``."""

from __future__ import annotations

import json

import pytest

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


def test_a_valid_world_exits_with_0(hmrsim):
    assert (0, "0 errors, 0 warnings\n") == hmrsim("map validate scenario1")[:2]


def test_every_error_is_listed_with_file_and_line(broken, hmrsim):
    code, out, _ = hmrsim("map validate", broken)

    first, second, total = out.splitlines()
    assert (1, "2 errors, 0 warnings") == (code, total)
    assert first.startswith(f"{broken}:2: lanes.1.to: ")
    assert second.startswith(f"{broken}:3: robots.wall_e.at: ")


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
def test_the_default_policy_is_named_with_its_reason(robots, line, tmp_path, hmrsim):
    path = tmp_path / "pair.yaml"
    path.write_text(f"waypoints: {{a: [0, 0], b: [9, 0]}}\nlanes: [[a, b]]\nrobots: {robots}\n")

    assert (0, f"{line}\n0 errors, 0 warnings\n", "") == hmrsim("map validate", path)


def test_json_lists_the_errors(broken, hmrsim):
    code, out, _ = hmrsim("map validate --json", broken)

    problems = [(one["line"], one["path"], one["severity"]) for one in json.loads(out)]
    assert (1, [(2, "lanes.1.to", "error"), (3, "robots.wall_e.at", "error")]) == (code, problems)


def test_warnings_have_their_place(tmp_path, hmrsim):
    path = tmp_path / "odd.yaml"
    path.write_text("waypoints: {a: [0, 0], b: [1, 0], c: [2, 0]}\nlanes: [[a, b]]\n")

    code, out, _ = hmrsim("map validate", path)

    lines = out.splitlines()
    assert (0, "0 errors, 1 warning") == (code, lines[-1])
    assert lines[0].startswith(f"{path}:1: warning: waypoints.c: ")


@pytest.mark.parametrize(
    "content", [None, "", "{", "just words", "\xff"], ids=["missing", "empty", "cut", "text", "bytes"]
)
def test_an_unreadable_file_exits_with_2(content, tmp_path, hmrsim):
    path = tmp_path / "world.yaml"
    if content is not None:
        path.write_bytes(content.encode("latin-1"))

    code, out, _ = hmrsim("map validate", path)

    assert (2, True) == (code, out.startswith(str(path)))


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
def test_invalid_names_and_options_are_errors(words, code, message, hmrsim):
    found, out, _ = hmrsim("map validate", *words)

    assert (code, True) == (found, message in out)


def test_run_rejects_a_broken_world(broken, hmrsim):
    code, out, err = hmrsim("run", broken)

    assert (2, "") == (code, out)
    assert err.startswith(f"{broken}:2: lanes.1.to: ")
