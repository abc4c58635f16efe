"""The Gymnasium environment: its interface, decisions and rewards."""

from __future__ import annotations

import pytest

pytest.importorskip("gymnasium", reason="environments need the extra gym")

import gymnasium
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from hmrsim.errors import WorldError
from hmrsim_gym import DispatchEnv, OrderFeature, nearest
from hmrsim_gym.observations import FAR

WAIT = 8
_ID = "hmrsim_gym:hmrsim/Dispatch-v0"


def steps(env, choose=nearest, **arguments):
    """Run an episode; return the result of each step, beginning with the reset."""
    observation, info = env.reset(**arguments)
    given = [(observation, 0.0, False, False, info)]
    while not (given[-1][2] or given[-1][3]):
        given.append(env.step(choose(given[-1][0])))
    return given


def test_passes_the_checker_of_gymnasium(make, world):
    check_env(make(world, render_mode="ansi").unwrapped)


def test_equal_seeds_give_equal_episodes(make):
    env = make("warehouse_orders", horizon=200)

    told = [repr(steps(env, seed=seed)) for seed in (3, 4, 3)]

    assert told[0] == told[2] != told[1]


def test_decision_is_due_when_a_robot_is_idle_and_an_order_is_free(make, world):
    env = make(world)

    _, info = env.reset(seed=1)

    assert (15.0, "wall_e", ["parcel_1"]) == (info["now"], info["robot"], info["orders"])


def test_episode_terminates_when_all_orders_are_delivered(make, world):
    *_, (_, _, terminated, truncated, info) = steps(make(world), seed=1)

    assert (True, False, 4, 0) == (terminated, truncated, info["delivered"], info["late"])


def test_horizon_truncates_the_episode(make, world):
    *_, (observation, _, terminated, truncated, info) = steps(make(world, horizon=40), seed=1)

    assert (False, True, 40.0) == (terminated, truncated, info["now"])
    assert [0] * 8 + [1] == observation["action_mask"].tolist()


def test_waiting_leaves_the_order_to_the_next_robot(make, world):
    """The next robot decides at the same time; then no robot does until the next order arrives."""
    env = make(world)
    env.reset(seed=1)

    told = [env.step(WAIT)[4] for _ in range(2)]

    assert [(15.0, "eve", 1), (30.0, "wall_e", 2)] == [
        (info["now"], info["robot"], len(info["orders"])) for info in told
    ]


def test_masked_action_waits(make, world):
    env = make(world)
    env.reset(seed=1)

    *_, info = env.step(5)

    assert "eve" == info["robot"]


def test_reward_counts_open_minutes_by_priority(make, world):
    world["demand"][0] |= {"at": ["store"], "count": 1, "priority": 2, "first": 0}
    env = make(world)
    env.reset(seed=1)

    _, reward, terminated, _, info = env.step(0)

    assert terminated
    assert -3 * info["now"] / 60 == pytest.approx(reward)


def test_late_minute_costs_five(make, world):
    """A minute costs one because the order is open, and four more because it is late."""
    world["demand"][0] |= {"count": 1, "first": 0, "within": 20}
    env = make(world, robots=["eve"], horizon=80)
    env.reset(seed=1)

    _, reward, _, truncated, _ = env.step(WAIT)

    assert truncated
    assert -(80 + 4 * 60) / 60 == pytest.approx(reward)


def test_features_of_an_order(make, world):
    world["demand"][0] |= {"at": ["door"]}
    env = make(world)

    observation, _ = env.reset(seed=1)

    row = observation["orders"][0]
    assert [1, 10 / 60, 10 / 60, 0, 1, 0, 0] == pytest.approx([*row])
    assert not observation["orders"][1:].any()


def test_order_without_due_time_or_rival_has_far_features(make, world):
    del world["demand"][0]["within"]
    observation, _ = make(world, robots=["eve"]).reset(seed=1)

    row = observation["orders"][0]
    assert [FAR, FAR] == [row[OrderFeature.SLACK], row[OrderFeature.RIVAL]]


def test_rows_show_the_nearest_and_the_most_urgent_orders(make, world):
    world["demand"] = [
        {"name": name, "at": [at], "to": "ward", "arrives": 1, "first": 0, "count": 2, "within": within}
        for name, at, within in (("near", "store", 90), ("far", "door", 300), ("urgent", "ward", 30))
    ]
    env = make(world, robots=["wall_e"], orders=2)
    env.reset(seed=1)
    *_, info = env.step(2)

    assert ["near_1", "urgent_1"] == info["orders"]


def test_step_needs_an_episode(make, world):
    env = make(world, horizon=15.5, disable_env_checker=True).unwrapped

    with pytest.raises(ResetNeeded, match="call reset first"):
        env.step(0)
    env.reset(seed=1)
    env.step(0)
    with pytest.raises(ResetNeeded, match="call reset first"):
        env.step(0)


def test_renders_robots_and_orders_as_text(make, world):
    env = make(world, render_mode="ansi")
    env.reset(seed=1)

    told = env.render()

    assert [
        "   15.000 s: 1 orders, 0 delivered, 0 late",
        "  wall_e at (0.0, 0.0) idle",
        "  eve at (20.0, 0.0) idle",
    ] == told.splitlines()[:3]
    assert told.splitlines()[3].endswith("to ward, due at 75 s")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"horizon": 0}, "horizon must be positive and finite, got 0 s"),
        ({"orders": 0}, "orders must be 1 at least, got 0"),
        ({"charge_below": 0.9}, "charge_below must be at least 0 and less than 0.8, got 0.9"),
        ({"robots": ["cart"]}, "robot 'cart' can't serve orders; those that can are: wall_e, eve"),
        ({"render_mode": "human"}, "render_mode must be None or 'ansi', got 'human'"),
        ({"world": "hospital"}, "world 'hospital' has no demand"),
    ],
)
def test_rejects_invalid_arguments(world, arguments, message):
    with pytest.raises(ValueError, match=message):
        DispatchEnv(**{"world": world, **arguments})


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vector_environment_has_the_episodes_of_its_seeds(make, world, mode):
    """Each of its environments has its own seed, as those of Gymnasium have; asynchronous ones are processes."""
    one, many = make(world), gymnasium.make_vec(_ID, num_envs=2, vectorization_mode=mode, world=world)
    try:
        seen, infos = many.reset(seed=[3, 4])
        after = many.step([0, 0])
        single = [(one.reset(seed=seed), one.step(0)) for seed in (3, 4)]
    finally:
        many.close()

    for number, ((first, info), (observation, reward, *_)) in enumerate(single):
        assert infos["now"][number] == info["now"]
        assert seen["orders"][number].tolist() == first["orders"].tolist()
        assert after[0]["orders"][number].tolist() == observation["orders"].tolist()
        assert after[1][number] == reward


def test_rejects_an_invalid_world():
    with pytest.raises(WorldError):
        DispatchEnv("no_such_world")
