"""The environment of Gymnasium: one agent tells each robot that is idle which order to serve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from hmrsim_gym.cost import Cost
from hmrsim_gym.dispatching import Dispatching
from hmrsim_gym.features import Observation, observation_space
from hmrsim_gym.observing import Observer
from hmrsim_gym.rendering import rendered
from hmrsim_gym.setting import SEEDS, AnyWorld, Setting

if TYPE_CHECKING:
    from hmrsim.simulation.orders import Order


class DispatchEnv(gymnasium.Env[Observation, int]):
    """Orders of a world are dispatched to its robots; each step is one decision, however long the time to the next.

    Action *i* gives the robot that asks, ``info["robot"]``, the order in row *i* of the observation; the last action
    has it wait until an order comes or becomes free, or another robot becomes idle. So does one that is masked. The
    reward is what orders have cost since the step before, 0 or less: see `hmrsim_gym.cost`.

    An episode is truncated at the horizon. It is terminated when all orders have ended and none will come.

    Args:
        world: The world, which has a demand.
        changes: What is laid over it, by path.
        robots: Who serves orders; all who can if left out.
        horizon: Simulated seconds.
        orders: How many orders a robot may choose from at most.
        charge_below: The share of its battery below which an idle robot goes to a charger.
        render_mode: ``ansi`` for a text, or None.

    Raises:
        WorldError: Something is wrong with the world; it has all errors.
        ValueError: An argument is out of range, or there is nothing to dispatch.
    """

    # The rate means nothing for decisions, but gymnasium's checks want one.
    metadata: dict[str, Any] = {"render_modes": ["ansi"], "render_fps": 1}  # noqa: RUF012 - as gymnasium declares it

    def __init__(
        self,
        world: AnyWorld = "warehouse_orders",
        *,
        changes: Mapping[str, Any] | None = None,
        robots: Sequence[str] | None = None,
        horizon: float = 1800.0,
        orders: int = 8,
        charge_below: float = 0.25,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in {None, "ansi"}:
            raise ValueError(f"render_mode must be None or 'ansi', got {render_mode!r}")
        self.render_mode = render_mode
        self._setting = Setting.of(
            world, changes=changes, robots=robots, horizon=horizon, orders=orders, charge_below=charge_below
        )
        self._observer = Observer(self._setting)
        self.observation_space = observation_space(orders)  # type: ignore[assignment]  # of a dict of any arrays
        self.action_space = spaces.Discrete(orders + 1)  # type: ignore[assignment]  # of numpy's integers
        self._run: Dispatching | None = None
        self._robot = self._setting.robots[0]
        self._choices: list[Order] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, up to its first decision.

        Args:
            seed: The seed of the world; without one it is chosen by the environment's random numbers.
            options: None are known.
        """
        super().reset(seed=seed, options=options)
        self.close()
        chosen = int(self.np_random.integers(SEEDS)) if seed is None else seed
        run = self._run = Dispatching(self._setting, chosen)
        self._cost = Cost(run.demand)
        run.run_on()
        self._cost.up_to(run.now)
        return self._observed(run)

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Tell the robot that asks what to do, and go on to the next decision.

        Raises:
            ResetNeeded: There is no episode, or it is over.
        """
        run = self._run
        if run is None or run.over:
            raise ResetNeeded("the episode is over, or none has begun; call reset first")
        number = int(action)
        if 0 <= number < len(self._choices):
            run.assign(self._robot, self._choices[number])
        else:
            run.wait(self._robot)
        run.run_on()
        reward = -self._cost.up_to(run.now)
        observation, info = self._observed(run)
        return observation, reward, run.ended, run.over and not run.ended, info

    def render(self) -> str | None:
        """Return the time, what robots do and which orders are free; None without a render mode."""
        if self.render_mode is None or self._run is None:
            return None
        return rendered(self._setting, self._run)

    def close(self) -> None:
        """End the episode."""
        run, self._run = self._run, None
        if run is not None:
            run.close()

    def _observed(self, run: Dispatching) -> tuple[Observation, dict[str, Any]]:
        asking = run.asking
        self._robot = asking[0] if asking else self._robot
        self._choices = self._observer.choices(run, self._robot) if asking and not run.over else []
        observation = self._observer.observe(run, self._robot, self._choices)
        totals = run.demand.totals
        return observation, {
            "action_mask": observation["action_mask"],
            "robot": self._robot,
            "orders": [order.name for order in self._choices],
            "now": run.now,
            "placed": totals.placed,
            "delivered": totals.delivered,
            "late": totals.late,
        }
