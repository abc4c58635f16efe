"""``hmrsim map convert`` and ``hmrsim map render``."""

from __future__ import annotations

import json
import struct
import sys
from xml.etree import ElementTree as ET

import pytest

from hmrsim.cli import main
from hmrsim.world_checks import load_world
from tests.paths import TESTS

DRAWING = "tests/unit/hmrsim/world/data/ward.drawio"


@pytest.mark.parametrize("name", ["world.yaml", "world.yml", "world.json"])
def test_a_drawing_becomes_a_native_world(name, tmp_path):
    """The world has the same hash."""
    out = tmp_path / name

    code = main(["map", "convert", DRAWING, str(out)])

    assert (0, load_world(DRAWING).hash) == (code, load_world(out).hash)


def test_includes_are_merged_in(tmp_path):
    """The written file needs no other file."""
    (tmp_path / "lanes.yaml").write_text("waypoints: {a: [0, 0], b: [1, 0]}\nlanes: [[a, b]]\n")
    main_file = tmp_path / "main.yaml"
    main_file.write_text("include: [lanes.yaml]\nrobots: {eve: {at: a}}\n")
    out = tmp_path / "out" / "all.yaml"
    out.parent.mkdir()

    main(["map", "convert", str(main_file), str(out)])
    assert load_world(main_file).hash == load_world(out).hash
    assert "include" not in out.read_text()


def test_a_route_graph_for_nav2(tmp_path, capsys):
    """Waypoints are points, lanes are MultiLineStrings between their ids, and omitted entities are reported."""
    source = tmp_path / "small.yaml"
    source.write_text(
        "name: small\nwaypoints: {a: [0, 0], b: [3, 0]}\nlanes: [{from: a, to: b, one_way: true, speed_limit: 0.5}]\n"
        "walls: [[[0, 1], [3, 1]], [[0, 2], [3, 2]]]\n"
    )
    out = tmp_path / "small.geojson"

    code = main(["map", "convert", str(source), str(out)])

    graph = json.loads(out.read_text())
    assert 0 == code
    assert f"{out}: GeoJSON holds no walls: 2 left out\n" == capsys.readouterr().err
    assert {
        "type": "Feature",
        "properties": {
            "id": 2,
            "startid": 0,
            "endid": 1,
            "cost": 3.0,
            "metadata": {"length": 3.0, "abs_speed_limit": 0.5, "one_way": True},
        },
        "geometry": {"type": "MultiLineString", "coordinates": [[[0.0, 0.0], [3.0, 0.0]]]},
    } == graph["features"][2]


def test_pixels_are_warned_of(tmp_path, capsys):
    """Nav2 expects meters."""
    main(["map", "convert", "scenario1", str(tmp_path / "s.geojson")])

    assert "coordinates stay in pixels, y downwards" in capsys.readouterr().err


def test_stdout(capsys):
    """``-`` writes the world itself to stdout, and nothing else."""
    code = main(["map", "convert", "scenario1", "-", "--to", "json"])

    assert (0, "scenario 1") == (code, json.loads(capsys.readouterr().out)["name"])


def test_what_was_written_as_json(tmp_path, capsys):
    """Programs get the file, the format, the hash and what was left out."""
    out = tmp_path / "h.geojson"
    main(["map", "convert", "scenario1", str(out), "--json"])

    told = json.loads(capsys.readouterr().out)
    assert (str(out), "geojson", load_world("scenario1").hash) == (told["file"], told["format"], told["hash"])
    assert {"bounds": 1, "walls": 8, "places": 2, "items": 1, "robots": 1, "remap": 3} == told["left_out"]


def test_the_schema_is_named_where_it_is(tmp_path):
    """Beside a folder with the schema the first line lets editors complete the file; elsewhere there is none."""
    (tmp_path / "schemas").mkdir()
    (tmp_path / "schemas" / "world.schema.json").write_text("{}")
    (tmp_path / "maps").mkdir()
    out = tmp_path / "maps" / "w.yaml"

    main(["map", "convert", "scenario1", str(out)])
    assert "# yaml-language-server: $schema=../schemas/world.schema.json" == out.read_text().splitlines()[0]


def test_nothing_is_overwritten_unasked(tmp_path, capsys):
    """A file that is there stays as it is without ``--force``."""
    out = tmp_path / "w.yaml"
    out.write_text("mine")

    code = main(["map", "convert", "scenario1", str(out)])
    assert (2, "mine") == (code, out.read_text())
    assert f"{out}: exists already; overwrite it with --force\n" == capsys.readouterr().err


def test_force_overwrites(tmp_path):
    """Another world can be there."""
    out = tmp_path / "w.yaml"
    main(["map", "convert", "scenario2", str(out)])

    code = main(["map", "convert", "scenario1", str(out), "--force"])
    assert (0, load_world("scenario1").hash) == (code, load_world(out).hash)


def test_no_half_written_file_is_left(tmp_path, monkeypatch, capsys):
    """When the disk is full there is neither the new file nor a part of it."""

    def fail(_self, _target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.replace", fail)
    out = tmp_path / "w.yaml"

    code = main(["map", "convert", "scenario1", str(out)])
    assert (1, []) == (code, list(tmp_path.iterdir()))
    assert f"hmrsim: {out}: can't be written: no space left on device\n" == capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("w.drawio", "unknown output format; expected one of .yaml, .json, .geojson, or --to"),
        ("w", "unknown output format; expected one of .yaml, .json, .geojson, or --to"),
        ("nowhere/w.yaml", "there is no folder"),
        ("folder.yaml", "is not a regular file; name another, or - for stdout"),
    ],
)
def test_what_cannot_be_written_is_2(name, error, tmp_path, capsys):
    """The line names the file and what would do."""
    (tmp_path / "folder.yaml").mkdir()

    code = main(["map", "convert", "scenario1", str(tmp_path / name)])
    assert 2 == code
    assert capsys.readouterr().err.startswith(f"{tmp_path / name}: {error}")


def test_a_broken_world_is_not_converted(tmp_path, capsys):
    """A file with errors leaves no other file behind."""
    source = tmp_path / "broken.yaml"
    source.write_text("waypoints: {a: [0, 0]}\nlanes: [[a, b]]\n")
    out = tmp_path / "out.yaml"

    code = main(["map", "convert", str(source), str(out)])
    assert (2, False) == (code, out.exists())
    assert capsys.readouterr().err.startswith(f"{source}:2: lanes.0.to: ")


DATA = TESTS / "unit" / "hmrsim" / "world" / "data"


@pytest.mark.parametrize(
    "source", ["ward.drawio", "crossing.geojson", "clinic.building.yaml", "depot.lif.json", "arena.map"]
)
@pytest.mark.parametrize("out", ["out.yaml", "out.json"])
def test_every_format_becomes_a_native_world(source, out, tmp_path):
    """With everything that the reader took from it."""
    code = main(["map", "convert", str(DATA / source), str(tmp_path / out)])

    assert (0, load_world(DATA / source).hash) == (code, load_world(tmp_path / out).hash)


@pytest.mark.parametrize("source", ["crossing.geojson", "clinic.building.yaml", "depot.lif.json", "arena.map"])
def test_every_format_becomes_a_route_graph(source, tmp_path):
    """With its waypoints and lanes."""
    out = tmp_path / "out.geojson"
    main(["map", "convert", str(DATA / source), str(out)])

    before, after = load_world(DATA / source).world, load_world(out).world
    assert (before.waypoints, before.lanes) == (after.waypoints, after.lanes)


def test_what_the_reader_left_out_is_told(tmp_path, capsys):
    """On stderr with its line, before what the other format can't hold; to programs, too."""
    out = tmp_path / "clinic.geojson"
    main(["map", "convert", str(DATA / "clinic.building.yaml"), str(out), "--json"])

    told = capsys.readouterr()
    expected = "clinic.building.yaml:22: warning: levels.L1.models: models: 1 left out"
    assert expected in told.err
    assert any(expected.replace(" warning:", "") in warning for warning in json.loads(told.out)["warnings"])
    assert f"{out}: GeoJSON holds no lifts: 1 left out\n" in told.err


@pytest.mark.parametrize("name", ["out.lif.json", "out.building.yaml", "out.map"])
def test_what_is_only_read_is_not_written(name, tmp_path):
    """Though the last part of its suffix could be."""
    assert 2 == main(["map", "convert", "scenario1", str(tmp_path / name)])


def test_neighbours_of_a_grid(tmp_path):
    """``--neighbours 4`` drops diagonal lanes."""
    out = tmp_path / "arena.json"
    main(["map", "convert", str(DATA / "arena.map"), str(out), "--neighbours", "4"])

    assert 23 == len(load_world(out).world.lanes)


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
    """Without the optional dependency, the error says what to install, and nothing is written."""
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
    """An output that can't be written is an error of one line, with exit code 2."""
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
    """A missing world is an error, as for other commands."""
    assert 2 == main(["map", "render", "nowhere.yaml"])
    assert "nowhere.yaml" in capsys.readouterr().err


def test_bottlenecks(capsys):
    """Traffic and bottlenecks are drawn, with the parts that they separate, and always the same."""
    codes = [main(["map", "render", "zoo/lift", "--bottlenecks"]) for _ in range(2)]

    out, err = capsys.readouterr()
    assert ([0, 0], "") == (codes, err)
    assert "<title>lift is the only way between 3 waypoints, 0 places | 3 waypoints, 0 places</title>" in out
    assert 2 == out.count("<title>ground_hall → ground_lift: 53.3% of trips, either way</title>")
    assert out[: len(out) // 2] == out[len(out) // 2 :]


def test_bottlenecks_of_a_world_without_lanes(tmp_path, capsys):
    """A world without bottlenecks is drawn, too."""
    path = tmp_path / "empty.yaml"
    path.write_text("name: nothing\n")

    assert 0 == main(["map", "render", str(path), "--bottlenecks"])
    assert "bottleneck" not in capsys.readouterr().out
