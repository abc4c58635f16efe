"""The colours of robot types can be told apart, also by those who see fewer colours."""

from __future__ import annotations

from itertools import combinations
from math import dist

import pytest

from hmrsim.drawing import PALETTE

SEEN = {
    "all colours": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "no red": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "no green": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.01182, 0.04294, 0.968881)),
    "no blue": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.3039)),
}
"""Linear RGB as it is seen, after Machado, Oliveira and Fernandes (2009) at full severity."""
_LMS = (
    (0.4122214708, 0.5363325363, 0.0514459929),
    (0.2119034982, 0.6806995451, 0.1073969566),
    (0.0883024619, 0.2817188376, 0.6299787005),
)
_OKLAB = (
    (0.2104542553, 0.793617785, -0.0040720468),
    (1.9779984951, -2.428592205, 0.4505937099),
    (0.0259040371, 0.7827717662, -0.808675766),
)
MIN_DISTANCE = 0.12
"""Distance in Oklab: 0.02 is just noticed where two colours touch, and these are spots far from each other."""


def times(matrix, vector):
    """Return a product."""
    return tuple(sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix)


def linear(colour):
    """Return the linear red, green and blue of #rrggbb."""
    parts = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return tuple(part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)


def oklab(rgb):
    """Return a linear colour where distances are as they are seen."""
    return times(_OKLAB, [value ** (1 / 3) for value in times(_LMS, [min(1.0, max(0.0, part)) for part in rgb])])


def luminance(colour):
    """Return the relative luminance of WCAG."""
    return sum(a * b for a, b in zip((0.2126, 0.7152, 0.0722), linear(colour), strict=True))


@pytest.mark.parametrize("who", SEEN)
def test_types_of_robots_differ(who):
    """The types differ in color, also for color-blind people, and in shape."""
    seen = {colour: oklab(times(SEEN[who], linear(colour))) for colour in PALETTE["types"]}

    near = {pair: dist(seen[pair[0]], seen[pair[1]]) for pair in combinations(seen, 2)}
    assert {} == {pair: round(away, 3) for pair, away in near.items() if away < MIN_DISTANCE}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_what_says_where_a_robot_looks_is_seen_on_its_body(theme):
    """The wedge has the color of the outline."""
    ink = luminance(PALETTE[theme]["robot_outline"])

    assert all((luminance(colour) + 0.05) / (ink + 0.05) > 2.3 for colour in PALETTE["types"])
