"""Traffic and bottlenecks over a map."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import pytest

from hmrsim.drawing import PALETTE, THEMES, Drawing, Overlay, Weak
from hmrsim.world import World

SVG = "{http://www.w3.org/2000/svg}"

WORLD = World.model_validate(
    {
        "waypoints": {"a": [0, 0], "b": [9, 0], "c": [9, 9], "d": [30, 9]},
        "lanes": [["b", "a"], ["b", "c"]],
        "lifts": {"tower": {"stops": ["c", "d"]}},
    }
)
OVERLAY = Overlay(
    {("a", "b"): 0.5, ("b", "c"): 0.1, ("c", "d"): 0.5},
    (
        Weak(("a", "b"), "lane", 1.0, "the only way"),
        Weak(("b",), "waypoint", 0.5, "a knot"),
        Weak(("c", "d"), "lift", 1, "x"),
    ),
)


def layer(picture, name):
    """Return the elements of one layer."""
    return [part for group in picture.iter(f"{SVG}g") if group.get("class") == name for part in group]


@pytest.mark.parametrize("theme", THEMES)
def test_more_traffic_is_wider_and_darker(theme):
    """The lane of most trips has the last color, in whichever order its ends are named."""
    overlay = Overlay(OVERLAY.shares, OVERLAY.weak, theme)
    picture = ET.fromstring(Drawing(WORLD, theme, overlay=overlay).svg())
    taken = [lane for lane in layer(picture, "lanes") if lane.get("stroke") in PALETTE["heat"][theme]]

    assert [PALETTE["heat"][theme][-1], PALETTE["heat"][theme][1]] == [lane.get("stroke") for lane in taken]
    assert float(taken[0].get("stroke-width")) > float(taken[1].get("stroke-width"))
    assert "50.0% of trips, either way" in taken[0][0].text


def test_bottlenecks_are_marked():
    """A lane is highlighted, a ride is dashed, and waypoints and stops of a lift have rings."""
    picture = ET.fromstring(Drawing(WORLD, overlay=OVERLAY).svg())
    ride, lane = layer(picture, "only-lanes")

    assert (None, "the only way") == (lane.get("stroke-dasharray"), lane[0].text)
    assert ("2 6", "c - d, a ride: 50.0% of trips, either way") == (ride.get("stroke-dasharray"), ride[0].text)
    assert ["x", "x", "a knot"] == [ring[0].text for ring in layer(picture, "only-waypoints")]


def test_the_legend_says_what_is_drawn():
    """The legend explains the overlay, if there is one."""
    drawn = {text.text for text in ET.fromstring(Drawing(WORLD, overlay=OVERLAY).svg()).iter(f"{SVG}text")}
    plain = {text.text for text in ET.fromstring(Drawing(WORLD).svg()).iter(f"{SVG}text")}

    assert {"up to 50% of trips", "bottleneck lane", "bottleneck waypoint or lift"} == drawn - plain


def test_an_empty_overlay_draws_nothing():
    """A world without lanes has neither traffic nor bottlenecks."""
    world = World.model_validate({"waypoints": {"a": [0, 0]}})

    assert Drawing(world).svg() == Drawing(world, overlay=Overlay({}, ())).svg()
