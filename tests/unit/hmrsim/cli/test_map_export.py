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

DATA = TESTS / "unit" / "hmrsim" / "world" / "data"


def test_includes_are_merged_in(tmp_path):
    (tmp_path / "lanes.yaml").write_text("waypoints: {a: [0, 0], b: [1, 0]}\nlanes: [[a, b]]\n")
    main_file = tmp_path / "main.yaml"
    main_file.write_text("include: [lanes.yaml]\nrobots: {eve: {at: a}}\n")
    out = tmp_path / "out" / "all.yaml"
    out.parent.mkdir()

    main(["map", "convert", str(main_file), str(out)])
    assert load_world(main_file).hash == load_world(out).hash
    assert "include" not in out.read_text()


def test_a_route_graph_has_points_and_lines(tmp_path, capsys):
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


def test_a_world_in_pixels_is_warned_of(tmp_path, hmrsim):
    """Nav2 expects route graphs in meters."""
    assert "coordinates stay in pixels, y downwards" in hmrsim("map convert scenario1", tmp_path / "s.geojson")[2]


def test_a_dash_writes_to_stdout(hmrsim):
    assert "scenario 1" == json.loads(hmrsim("map convert scenario1 - --to json")[1])["name"]


def test_json_describes_the_written_file(tmp_path, capsys):
    out = tmp_path / "h.geojson"
    main(["map", "convert", "scenario1", str(out), "--json"])

    output = json.loads(capsys.readouterr().out)
    assert (str(out), "geojson", load_world("scenario1").hash) == (output["file"], output["format"], output["hash"])
    assert {"bounds": 1, "walls": 8, "places": 2, "items": 1, "robots": 1, "remap": 3} == output["left_out"]


def test_the_first_line_names_a_schema_beside_the_file(tmp_path):
    (tmp_path / "schemas").mkdir()
    (tmp_path / "schemas" / "world.schema.json").write_text("{}")
    (tmp_path / "maps").mkdir()
    out = tmp_path / "maps" / "w.yaml"

    main(["map", "convert", "scenario1", str(out)])
    assert "# yaml-language-server: $schema=../schemas/world.schema.json" == out.read_text().splitlines()[0]


def test_only_force_overwrites(tmp_path, capsys):
    out = tmp_path / "w.yaml"
    out.write_text("mine")

    assert (2, "mine") == (main(["map", "convert", "scenario1", str(out)]), out.read_text())
    assert f"{out}: exists already; overwrite it with --force\n" == capsys.readouterr().err
    assert 0 == main(["map", "convert", "scenario1", str(out), "--force"])
    assert load_world("scenario1").hash == load_world(out).hash


def test_no_half_written_file_is_left(tmp_path, monkeypatch, capsys):
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
        ("w.lif.json", "unknown output format; expected one of .yaml, .json, .geojson, or --to"),
        ("w.building.yaml", "unknown output format; expected one of .yaml, .json, .geojson, or --to"),
        ("w.map", "unknown output format; expected one of .yaml, .json, .geojson, or --to"),
        ("nowhere/w.yaml", "there is no folder"),
        ("folder.yaml", "is not a regular file; name another, or - for stdout"),
    ],
)
def test_unwritable_formats_exit_with_2(name, error, tmp_path, hmrsim):
    (tmp_path / "folder.yaml").mkdir()

    code, _, err = hmrsim("map convert scenario1", tmp_path / name)

    assert (2, True) == (code, err.startswith(f"{tmp_path / name}: {error}"))


def test_a_broken_world_is_not_converted(tmp_path, capsys):
    source = tmp_path / "broken.yaml"
    source.write_text("waypoints: {a: [0, 0]}\nlanes: [[a, b]]\n")
    out = tmp_path / "out.yaml"

    code = main(["map", "convert", str(source), str(out)])
    assert (2, False) == (code, out.exists())
    assert capsys.readouterr().err.startswith(f"{source}:2: lanes.0.to: ")


@pytest.mark.parametrize(
    "source", ["ward.drawio", "crossing.geojson", "clinic.building.yaml", "depot.lif.json", "arena.map"]
)
@pytest.mark.parametrize("out", ["out.yaml", "out.yml", "out.json"])
def test_every_format_becomes_a_native_world(source, out, tmp_path):
    code = main(["map", "convert", str(DATA / source), str(tmp_path / out)])

    assert (0, load_world(DATA / source).hash) == (code, load_world(tmp_path / out).hash)


@pytest.mark.parametrize("source", ["crossing.geojson", "clinic.building.yaml", "depot.lif.json", "arena.map"])
def test_every_format_becomes_a_route_graph(source, tmp_path):
    out = tmp_path / "out.geojson"
    main(["map", "convert", str(DATA / source), str(out)])

    before, after = load_world(DATA / source).world, load_world(out).world
    assert (before.waypoints, before.lanes) == (after.waypoints, after.lanes)


def test_parts_that_the_reader_left_out_are_reported(tmp_path, capsys):
    out = tmp_path / "clinic.geojson"
    main(["map", "convert", str(DATA / "clinic.building.yaml"), str(out), "--json"])

    output = capsys.readouterr()
    expected = "clinic.building.yaml:22: warning: levels.L1.models: models: 1 left out"
    assert expected in output.err
    assert any(expected.replace(" warning:", "") in warning for warning in json.loads(output.out)["warnings"])
    assert f"{out}: GeoJSON holds no lifts: 1 left out\n" in output.err


def test_neighbors_option_drops_diagonal_lanes(tmp_path):
    out = tmp_path / "arena.json"
    main(["map", "convert", str(DATA / "arena.map"), str(out), "--neighbours", "4"])

    assert 23 == len(load_world(out).world.lanes)


def test_svg_goes_to_stdout_by_default(hmrsim):
    code, out, err = hmrsim("map render scenario1")

    assert (0, "") == (code, err)
    assert "scenario 1" == ET.fromstring(out)[0].text


def test_svg_can_be_written_to_a_file(tmp_path, hmrsim):
    file = tmp_path / "map.svg"

    assert [(0, "", "")] * 2 == [hmrsim("map render scenario1 -o", file) for _ in range(2)]
    assert hmrsim("map render scenario1")[1] == file.read_text(encoding="utf-8")
    assert [file] == list(tmp_path.iterdir())


def test_options_change_the_picture(hmrsim):
    _, out, _ = hmrsim("map render scenario1 --theme dark --width 400 --no-names --no-legend")

    assert 'width="400"' in out
    assert "#11151c" in out
    assert "<text" not in out


def test_added_robots_are_drawn(hmrsim):
    assert "<title>eve, fetcher</title>" in hmrsim("map render scenario1 --robot eve@300,80:fetcher")[1]


def test_a_png_has_the_scaled_size(tmp_path):
    pytest.importorskip("resvg_py", reason="a PNG needs resvg_py")
    file = tmp_path / "map.PNG"

    assert 0 == main(["map", "render", "scenario1", "-o", str(file), "--width", "300", "--scale", "3"])
    head = file.read_bytes()[:24]
    assert (b"\x89PNG\r\n\x1a\n", 900) == (head[:8], struct.unpack(">I", head[16:20])[0])


def test_png_without_its_package_names_the_extra(tmp_path, capsys, monkeypatch):
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
def test_an_unwritable_picture_is_an_error(arguments, message, tmp_path, capsys, monkeypatch):
    (tmp_path / "folder.svg").mkdir()
    monkeypatch.chdir(tmp_path)

    assert 2 == main(["map", "render", "scenario1", *arguments])
    assert f"{message}\n" == capsys.readouterr().err


@pytest.mark.parametrize("option", [["--width", "20"], ["--width", "x"], ["--scale", "0"], ["--scale", "nan"]])
def test_options_out_of_range_are_rejected(option, hmrsim):
    code, _, err = hmrsim("map render scenario1", *option)

    assert (2, True) == (code, f"argument {option[0]}: {option[1]!r} is no" in err)


def test_bottlenecks_and_traffic_are_drawn(capsys):
    codes = [main(["map", "render", "zoo/lift", "--bottlenecks"]) for _ in range(2)]

    out, err = capsys.readouterr()
    assert ([0, 0], "") == (codes, err)
    assert "<title>lift is the only way between 3 waypoints, 0 places | 3 waypoints, 0 places</title>" in out
    assert 2 == out.count("<title>ground_hall → ground_lift: 53.3% of trips, either way</title>")
    assert out[: len(out) // 2] == out[len(out) // 2 :]


def test_a_world_without_bottlenecks_is_drawn(tmp_path, hmrsim):
    path = tmp_path / "empty.yaml"
    path.write_text("name: nothing\n")

    code, out, _ = hmrsim("map render --bottlenecks", path)

    assert (0, False) == (code, "bottleneck" in out)
