"""Files of other formats, other encodings and no name."""

from __future__ import annotations

import pytest

from hmrsim.errors import WorldError
from hmrsim.world.formats import choose
from hmrsim.world_checks import load_world

NOTHING = {
    "drawio": "<mxGraphModel><root/></mxGraphModel>",
    "geojson": '{"features": [],\n "type" :\n"FeatureCollection"}',
    "rmf_building": "name: office\nlevels:\n  L1:\n    lanes: []\n",
    "lif": '{"metaInformation": {"projectIdentification": "p", "lifVersion": "1.0.0"}, "layouts": []}',
    "movingai": "type octile\nheight 1\nwidth 2\nmap\n..\n",
    "native": "name: office\n",
}


@pytest.mark.parametrize("name", ["world.json", "world.yaml", "world.map", "world.geojson", "world.txt"])
@pytest.mark.parametrize("kind", NOTHING)
def test_what_is_in_a_file_says_what_it_is(kind, name):
    """The content decides on the format, whatever the file name."""
    assert kind == choose(name, NOTHING[kind]).name


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("a.building.yaml", "rmf_building"),
        ("a.lif.json", "lif"),
        ("A.LIF.JSON", "lif"),
        ("a.geojson", "geojson"),
        ("a.map", "movingai"),
        ("a.drawio", "drawio"),
        ("a.yaml", "native"),
    ],
)
def test_the_longest_suffix_says_what_the_text_does_not(name, kind):
    """If no format matches the content, the suffix decides on the reported errors."""
    assert kind == choose(name, "?").name


def test_native_file_is_not_taken_for_another(load):
    """A native file can contain words of other formats, and have a similar name."""
    text = "name: levels\nplaces: {FeatureCollection: {at: [0, 0]}, layouts: {at: [1, 1]}}\n"

    assert "levels" == load(text, "office.building.yaml").world.name


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "latin-1"])
def test_other_encodings_are_reported_with_a_remedy(tmp_path, encoding):
    """Some editors save UTF-16 by default."""
    path = tmp_path / "world.yaml"
    path.write_bytes("name: \u00e4".encode(encoding))

    with pytest.raises(WorldError, match=r"is not UTF-8: byte 0x[0-9a-f]{2}; save it as UTF-8$"):
        load_world(path)


def test_empty_name_is_reported():
    """An empty name is not the current folder."""
    with pytest.raises(WorldError, match=r"^the name of the world is empty; expected a file, or the name of a shipped"):
        load_world("")
