"""The page's motions equal the simulator's."""

from __future__ import annotations

import itertools
import math
import random

from hmrsim.geometry import Pose, distance, turn
from hmrsim.navigation.motion import drive
from hmrsim.navigation.route import Leg

_POSES = """async (cases) => {
  const {Motion} = await import('/model/motion.js');
  return cases.map(([said, began, times]) => times.map((time) => new Motion(said, began).poseAt(time)));
}"""


def _pieces(chance):
    """Return the motions of a random robot along a random route."""
    points = [(chance.uniform(-50, 50), chance.uniform(-50, 50)) for _ in range(chance.randint(2, 5))]
    legs = [
        Leg(a, b, distance(a, b), ride=chance.choice((0.0, 0.0, 0.0, 9.0)), speed_limit=chance.choice((math.inf, 0.7)))
        for a, b in itertools.pairwise(points)
    ]
    way = drive(
        Pose(*points[0], chance.uniform(-3, 3)),
        legs,
        chance.choice((None, 1.0)),
        speed=chance.uniform(0.5, 3),
        acceleration=chance.choice((None, 0.4, 5.0)),
        turning_rate=chance.choice((None, 0.8)),
        run_up=chance.choice((0.0, 0.3)),
    )
    return [way.piece(number) for number in range(len(way.seconds))]


def test_poses_during_random_motions_equal_pythons(viewed, open_page):
    chance = random.Random(7)
    pieces = [piece for _ in range(60) for piece in _pieces(chance)]
    pieces += [piece.first(piece.duration * chance.random()) for piece in pieces[::5]]
    shares = (0.0, 0.1, 0.37, 0.5, 0.81, 0.999, 1.0, 1.5)
    cases = [(piece.describe(), 100.0, [100.0 + piece.duration * share for share in shares]) for piece in pieces]
    _, url = viewed("scenario1")

    shown = open_page(url).evaluate(_POSES, cases)

    expected = [[piece.pose(piece.duration * share) for share in shares] for piece in pieces]
    assert len(pieces) > 150
    assert [] == [
        (piece, share, there, here)
        for piece, theirs, ours in zip(pieces, shown, expected, strict=True)
        for share, there, here in zip(shares, theirs, ours, strict=True)
        if math.dist(there[:2], here.point) > 1e-6 or abs(turn(there[2], here.yaw)) > 1e-6
    ]
