"""Scripts in world files."""

from __future__ import annotations

WORLD = """\
waypoints: {{home: [1, 2], shelf: [9, 2]}}
lanes: [[home, shelf]]
items: {{parcel: {{at: shelf}}}}
robots:
  wall_e:
    at: home
    type: fetcher
    script:
      - Go {place}
      - {second}
"""


def test_every_order_is_checked_with_its_line(errors_of):
    """All that is wrong is told at once, and what would do."""
    first, second = errors_of(WORLD.format(place="shelv", second="Fly home"))

    assert "9: robots.wall_e.script.0: no waypoint, place or dock 'shelv'; did you mean 'shelf'?" == first
    assert second.startswith("10: robots.wall_e.script.1: no order begins with 'Fly'; there are: Back DISTANCE [SPEED]")


def test_a_robot_needs_what_an_order_takes(errors_of):
    """A carrier grabs nothing."""
    text = WORLD.format(place="shelf", second="Grab parcel").replace("fetcher", "carrier")

    assert ["10: robots.wall_e.script.1: 'Grab parcel' takes a claw, which wall_e does not have"] == errors_of(text)


def test_what_could_follow_from_another_error_is_not_told(errors_of):
    """A waypoint that was left out may be the one that is meant."""
    text = WORLD.format(place="attic", second="Grab parcel").replace("shelf: [9, 2]", "shelf: [9, 2], attic: [x, 2]")

    assert ["1: waypoints.attic.0"] == [error[: error.index(": expected")] for error in errors_of(text)]
