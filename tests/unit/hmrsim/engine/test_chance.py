"""Random number streams, and whether a world uses any."""

from __future__ import annotations

import random

import pytest

from hmrsim.distributions import Distribution
from hmrsim.engine.chance import Chance

UNIFORM = Distribution.model_validate({"uniform": {"low": 0, "high": 1}})


def test_constants_draw_no_random_number():
    chance = Chance()
    chance.begin(7)
    chance.draw(5.0, "door", "opening_time")
    chance.choose(1, "order", "at", 1)
    chance.stream("seed")

    assert not chance.used


@pytest.mark.parametrize(
    "use",
    [
        lambda chance: chance.draw(UNIFORM, "door", "opening_time"),
        lambda chance: chance.drawn(UNIFORM, "door", "opening_time", 3),
        lambda chance: chance.choose(2, "order", "at", 1),
        lambda chance: chance.stream("seed").random(),
        lambda chance: chance.stream("seed").expovariate(1.0),
        lambda chance: chance.stream("seed").choice("ab"),
        lambda chance: chance.stream("seed").randbytes(2),
    ],
)
def test_each_draw_is_recorded(use):
    chance = Chance()
    chance.begin(7)
    use(chance)
    chance.begin(7)

    assert chance.used


@pytest.mark.parametrize(
    "use", [lambda r: r.random(), lambda r: r.gauss(0, 1), lambda r: r.sample(range(9), 5), lambda r: r.getrandbits(70)]
)
def test_a_stream_is_python_s_generator_for_its_seed(use):
    assert use(random.Random("a/b")) == use(Chance().stream("a/b"))
