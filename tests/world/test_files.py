"""Files of other formats, other encodings and no name."""

from __future__ import annotations

import pytest

from hmrsim.errors import WorldError
from hmrsim.world import load_world

LIF = '{"metaInformation": {"projectIdentification": "p", "lifVersion": "1.0.0"}, "layouts": []}'


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("lanes.geojson", '{"type": "FeatureCollection", "name": "lanes", "features": []}', "GeoJSON"),
        ("lanes.json", '\n{"features": [],\n "type" :\n"FeatureCollection"}', "GeoJSON"),
        ("office.building.yaml", "name: office\nlevels:\n  L1:\n    lanes: []\n", "an RMF building"),
        ("site.lif.json", LIF, "LIF"),
        ("arena.map", "type octile\nheight 1\nwidth 2\nmap\n..\n", "a MovingAI map"),
    ],
)
def test_known_format_that_is_not_read_is_told_once(errors_of, name, text, what):
    """What is in the file says what it is, and one line says that it can't be read."""
    expected = "expected one of .drawio, .json, .xml, .yaml, .yml"

    assert [f"is {what}, which is not read yet; {expected}"] == errors_of(text, name)


def test_native_file_is_not_taken_for_another(load):
    """Words of other formats may be in it, and its name may be like theirs."""
    text = "name: levels\nplaces: {FeatureCollection: {at: [0, 0]}, layouts: {at: [1, 1]}}\n"

    assert "levels" == load(text, "office.building.yaml").world.name


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "latin-1"])
def test_other_encodings_are_told_what_would_do(tmp_path, encoding):
    """Some editors save UTF-16 unasked."""
    path = tmp_path / "world.yaml"
    path.write_bytes("name: \u00e4".encode(encoding))

    with pytest.raises(WorldError, match=r"is not UTF-8: byte 0x[0-9a-f]{2}; save it as UTF-8$"):
        load_world(path)


def test_empty_name_is_told():
    """It is no folder."""
    with pytest.raises(WorldError, match=r"^the name of the world is empty; expected a file, or the name of a shipped"):
        load_world("")
