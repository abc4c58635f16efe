"""``hmrsim map render``."""

from __future__ import annotations

import struct
import sys
from xml.etree import ElementTree as ET

import pytest

from hmrsim.cli import main


def test_svg_on_stdout(capsys):
    """Without an output the picture is on stdout, and it alone."""
    code = main(["map", "render", "scenario1"])

    out, err = capsys.readouterr()
    assert (0, "") == (code, err)
    assert "scenario 1" == ET.fromstring(out)[0].text


def test_svg_to_a_file(tmp_path, capsys):
    """A file gets what stdout would, and may be written again."""
    main(["map", "render", "scenario1"])
    file = tmp_path / "map.svg"
    codes = [main(["map", "render", "scenario1", "-o", str(file)]) for _ in range(2)]

    assert [0, 0] == codes
    assert capsys.readouterr().out == file.read_text(encoding="utf-8")
    assert [file] == list(tmp_path.iterdir())


def test_options(capsys):
    """Theme, width and what is left out change the picture."""
    main(["map", "render", "scenario1", "--theme", "dark", "--width", "400", "--no-names", "--no-legend"])

    out = capsys.readouterr().out
    assert 'width="400"' in out
    assert "#11151c" in out
    assert "<text" not in out


def test_what_the_command_line_adds_is_drawn(capsys):
    """Robots that are added on the command line are in the picture, in any format of world."""
    main(["map", "render", "scenario1", "--robot", "eve@300,80:fetcher"])

    assert "<title>eve, fetcher</title>" in capsys.readouterr().out


def test_png(tmp_path):
    """A PNG has as many pixels as the drawing's size and the scale say."""
    pytest.importorskip("resvg_py", reason="a PNG needs resvg_py")
    file = tmp_path / "map.PNG"

    assert 0 == main(["map", "render", "scenario1", "-o", str(file), "--width", "300", "--scale", "3"])
    head = file.read_bytes()[:24]
    assert (b"\x89PNG\r\n\x1a\n", 900) == (head[:8], struct.unpack(">I", head[16:20])[0])


def test_png_without_its_package(tmp_path, capsys, monkeypatch):
    """Where what makes pixels is missing, it is said what to install, and nothing is written."""
    monkeypatch.setitem(sys.modules, "resvg_py", None)

    assert 2 == main(["map", "render", "scenario1", "-o", str(tmp_path / "map.png")])
    assert "pip install 'hmrsim[png]'" in capsys.readouterr().err
    assert [] == list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "map.gif"], "map.gif: unknown picture format; expected one of .svg, .png"),
        (["-o", "nowhere/map.svg"], "nowhere/map.svg: there is no folder 'nowhere'"),
        (["-o", "folder.svg"], "folder.svg: is not a regular file; name another, or - for stdout"),
        (
            ["-o", "map.png", "--width", "20000", "--scale", "8"],
            "a PNG of 160000 x 107200 pixels is too large; give less --width or --scale",
        ),
    ],
    ids=["format", "folder", "directory", "size"],
)
def test_what_can_not_be_written(arguments, message, tmp_path, capsys, monkeypatch):
    """An output that can't be written is told on one line, with exit code 2."""
    (tmp_path / "folder.svg").mkdir()
    monkeypatch.chdir(tmp_path)

    assert 2 == main(["map", "render", "scenario1", *arguments])
    assert f"{message}\n" == capsys.readouterr().err


@pytest.mark.parametrize("option", [["--width", "20"], ["--width", "x"], ["--scale", "0"], ["--scale", "nan"]])
def test_options_out_of_range(option, capsys):
    """Widths and scales that make no sense are refused with the option's name."""
    assert 2 == main(["map", "render", "scenario1", *option])
    assert f"argument {option[0]}: {option[1]!r} is no" in capsys.readouterr().err


def test_no_such_world(capsys):
    """A world that is not there is told as everywhere."""
    assert 2 == main(["map", "render", "nowhere.yaml"])
    assert "nowhere.yaml" in capsys.readouterr().err


def test_bottlenecks(capsys):
    """Where traffic concentrates, and what is the only way, with what that separates; the same each time."""
    codes = [main(["map", "render", "zoo/lift", "--bottlenecks"]) for _ in range(2)]

    out, err = capsys.readouterr()
    assert ([0, 0], "") == (codes, err)
    assert "<title>lift is the only way between 3 waypoints, 0 places | 3 waypoints, 0 places</title>" in out
    assert 2 == out.count("<title>ground_hall → ground_lift: 53.3% of trips, either way</title>")
    assert out[: len(out) // 2] == out[len(out) // 2 :]


def test_bottlenecks_of_a_world_without_lanes(tmp_path, capsys):
    """There are none."""
    path = tmp_path / "empty.yaml"
    path.write_text("name: nothing\n")

    assert 0 == main(["map", "render", str(path), "--bottlenecks"])
    assert "bottleneck" not in capsys.readouterr().out
