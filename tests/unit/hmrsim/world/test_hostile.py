"""Files that are broken or hostile."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.documents.yaml_text import read_yaml
from hmrsim.errors import WorldError
from hmrsim.world import World
from hmrsim.world.files import AS_IT_IS
from hmrsim.world.formats import _reading, registry
from hmrsim.world.segments import SegmentGrid
from hmrsim.world_checks import lanes, load_world
from hmrsim.world_checks.checks import check
from hmrsim.world_checks.loading import validate
from tests.profiles import examples


def test_number_of_reported_errors_is_limited(write):
    path = write("\n".join(["name: many", *(f"k{i}: {i}" for i in range(3000))]))
    with pytest.raises(WorldError) as caught:
        load_world(path)

    first, second, *_ = caught.value.problems
    assert first.message == "has 3000 errors; only these are reported"
    assert (second.line, second.path) == (2, "k0")
    assert len(caught.value.problems) == 1000


def test_a_merge_key_is_reported_with_its_line(errors_of):
    """YAML 1.2 has no merge keys."""
    errors = errors_of("robots:\n  eve: &eve {at: [0, 0]}\n  wall_e:\n    <<: *eve\n")

    assert errors == ["4: has the merge key <<, which YAML 1.2 no longer has; write the keys out"]


@pytest.mark.parametrize(
    ("start", "end", "wall", "compared"),
    [
        ((500.0, 700.5), (501.0, 701.5), 701, 250),
        ((10.0, 1e7), (10.0, -1e7), 0, 3000),
        ((-1e7, -5000.0), (1e7, -5000.0), None, 3000),
    ],
    ids=["short", "through all walls", "beside all walls"],
)
def test_a_line_is_compared_with_few_of_many_long_walls(start, end, wall, compared):
    grid = SegmentGrid([((0.0, float(y)), (1000.0, float(y))) for y in range(1000)])

    assert grid.first_crossing(start, end) == wall
    assert grid.looked < compared


def test_lanes_and_walls_are_compared_within_bounds(monkeypatch):
    monkeypatch.setattr(lanes, "_MAX_COMPARISONS", 0)
    world = World.model_validate(
        {
            "waypoints": {"a": [0, 0], "b": [2, 0], "c": [4, 0]},
            "lanes": [["a", "b"], ["b", "c"]],
            "walls": [[[1, -1], [1, 1]]],
        }
    )

    assert [(finding.path, finding.message) for finding in check(world)] == [
        (("lanes", 0), "'a'-'b' crosses walls.0; a drawn lane is open all the same"),
        (("lanes",), "and walls are too many to compare all; those from lanes.1 on were not"),
    ]


DATA = Path(__file__).parent / "data"
FILES = {"geojson": "crossing.geojson", "lif": "depot.lif.json", "rmf_building": "clinic.building.yaml"}
PLAIN = {kind: read_yaml((DATA / name).read_text(encoding="utf-8"))[0] for kind, name in FILES.items()}

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


def places(value, path=()):
    for key, part in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield (*path, key)
        yield from places(part, (*path, key))


def changed(value, path, new):
    if not path:
        return new
    parts = dict(value) if isinstance(value, dict) else list(value)
    parts[path[0]] = changed(parts[path[0]], path[1:], new)
    return parts


@pytest.mark.parametrize("kind", FILES)
@given(st.data())
@examples(150)
def test_any_change_of_a_file_gives_a_world_or_findings(kind, data):
    path = data.draw(st.sampled_from([*places(PLAIN[kind])]))
    text = json.dumps(changed(PLAIN[kind], path, data.draw(values)))
    try:
        document = registry()[kind].read(text, "file", AS_IT_IS)
    except WorldError as error:
        assert error.problems  # noqa: PT017  # either will do
    else:
        validated = validate(document.data)
        assert validated.value or validated.findings or document.findings
        assert all(document.line(finding.path) is not None for finding in validated.findings)


@pytest.mark.parametrize("kind", [*FILES, "movingai"])
@given(st.text(max_size=100) | values.map(json.dumps))
def test_any_text_is_a_document_or_an_error(kind, text):
    try:
        assert registry()[kind].read(text, "file", AS_IT_IS)
    except WorldError as error:
        assert error.problems  # noqa: PT017  # either will do


@pytest.mark.parametrize("name", ["g.geojson", "a.lif.json"])
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "is nested too deep|is not valid JSON"),
        ('{"layouts": ' * 100_000, "is nested too deep|is not valid JSON"),
        ('{"type": "FeatureCollection", "features": [NaN]}', "is not valid JSON: NaN is not a number"),
        ('{"type": "FeatureCollection", "features": [-Infinity]}', "is not valid JSON: -Infinity is not a number"),
        (f'{{"layouts": [{"9" * 5000}]}}', "is not valid JSON: "),
        ("[1, 2]", r":1: expected a mapping, got \[1, 2\]"),
        ('{"features": [\n1,\n}', ":3: is not valid JSON: "),
    ],
    ids=lambda value: repr(value[:20]),
)
def test_hostile_json_is_one_error(write, name, text, message):
    with pytest.raises(WorldError, match=message) as caught:
        load_world(write(text, name))

    assert 1 == len(caught.value.problems)


def test_a_json_file_of_too_many_values_is_rejected(write, monkeypatch):
    monkeypatch.setattr(_reading, "_MAX_VALUES", 10)

    with pytest.raises(WorldError, match="has more than 10 values"):
        load_world(write('{"features": [' + "[]," * 10 + "0]}", "g.geojson"))


def test_numbers_beyond_all_maps_are_reported(errors_of):
    far = [
        {"type": "Feature", "properties": {"id": i}, "geometry": {"type": "Point", "coordinates": [number, 0]}}
        for i, number in enumerate((10**400, 1e308, 1e8))
    ]
    text = json.dumps({"features": far}).replace("1e+308", "1e999")

    first, second, third = errors_of(text, "g.geojson")
    assert "features.0.geometry.coordinates.0: expected a number of at most 1e+15, got 1000000" in first
    assert "features.1.geometry.coordinates.0: expected a number of at most 1e+15, got inf" in second
    assert "waypoints.node_2.0: must be at most 1e+07, got 100000000.0" in third


def test_number_of_reported_errors_of_other_formats_is_limited(write):
    text = json.dumps({"features": [5] * 5000})
    with pytest.raises(WorldError) as caught:
        load_world(write(text, "g.geojson"))

    assert len(caught.value.problems) <= 1001
