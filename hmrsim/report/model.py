"""The contents of a report: times in simulated seconds since the run began, lengths in the world's unit.

Unknown values are None, for instance where a trace could not be run again.
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from hmrsim.history.robots import State

Status = Literal["ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED"]

ENDED: tuple[Status, ...] = ("SUCCEEDED", "CANCELED", "ABORTED")


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True)


class Source(_Model):
    """The source of a report, and what is missing in it."""

    kind: Literal["trace", "recording"]
    exact: bool = Field(description="Whether motions are known, so that distances and states are exact.")
    complete: bool = Field(description="Whether it was complete, and not truncated.")
    notes: tuple[str, ...] = Field((), description="What is missing or should be noted, as text.")


class World(_Model):
    """The world of the run."""

    name: str
    hash: str
    units: str
    seed: int | None
    hmrsim: str
    contract: int | None


class Summary(_Model):
    """The totals of the run."""

    sim_time: float
    robots: int
    goals: int = Field(description="Goals that were accepted.")
    by_status: dict[str, int]
    by_action: dict[str, dict[str, int]] = Field(description="Number of goals by action and status.")
    rejected: int
    success_rate: float | None = Field(description="Succeeded, as a share of the goals that ended; None if none did.")
    distance: float | None
    energy_used: float | None
    energy_charged: float | None
    waits: int
    waited: float = Field(description="Seconds, of all robots together.")
    reroutes: int
    made_room: int
    deadlocks: int
    faults: int


class Robot(_Model):
    """The account of one robot."""

    name: str
    type: str
    began: float = Field(description="When it was added; 0 unless it was spawned later.")
    ended: float = Field(description="When it was removed, or the run ended.")
    distance: float | None
    energy_used: float | None = Field(description="Units of energy; None without a battery.")
    energy_charged: float | None
    battery: float | None = Field(description="Remaining share of the battery.")
    lowest_battery: float | None
    seconds: dict[State, float] = Field(description="Seconds in each state.")
    share: dict[State, float] = Field(description="Share of its time in each state; their sum is 1.")
    goals: int
    succeeded: int
    failed: int = Field(description="Goals that were aborted.")
    canceled: int
    waits: int
    waited: float
    queued: float = Field(description="Seconds in queues before docks.")
    waited_for: dict[str, float] = Field(description="Seconds by the robot, or the reason, for which it waited.")


class Goal(_Model):
    """One goal, from its acceptance to its end."""

    robot: str
    action: str
    goal_id: str
    accepted: float
    ended: float | None
    duration: float | None
    status: Status
    target: str = Field(description="The goal in a few words.")
    target_x: float | None
    target_y: float | None
    distance: float | None
    waited: float
    waits: int
    reroutes: int
    error_code: int | None
    error_msg: str


class Wait(_Model):
    """A wait of a robot on its way, or in the queue of a dock; or a part of one, where what it waits for changes."""

    robot: str
    began: float
    ended: float
    duration: float
    kind: Literal["way", "dock"]
    robots: tuple[str, ...] = Field(description="For whom.")
    why: str = Field(description="What it waited for, if not for robots.")
    lane: tuple[str, str] | None
    x: float | None
    y: float | None
    goal_id: str
    until: str = Field(
        description="What ended it: went_on, rerouted, stopped, made_room, docked, end, …;"
        " waiting where it goes on as the next wait"
    )


class FirstCause(_Model):
    """A first cause of waits: the end of the chain of causes that begins with each waiting robot."""

    cause: str = Field(description="A robot, an obstacle, a dock, its turn, or the robots of a circle.")
    state: str = Field(description="The state of the robot; or obstacle, queue, turn or circle.")
    seconds: float = Field(description="For how long robots waited because of it, in all.")
    robots: tuple[str, ...] = Field(description="The robots that waited because of it, longest first.")


class Span(_Model):
    """A period in which a robot was in one state."""

    robot: str
    state: State
    began: float
    ended: float
    duration: float


class Error(_Model):
    """A goal that was aborted or rejected, and its circumstances."""

    at: float
    robot: str
    action: str
    goal_id: str
    status: Literal["ABORTED", "REJECTED"]
    error_code: int | None
    error_name: str = Field(description="The code's name, or the reason of a rejection.")
    error_msg: str
    target: str
    waited_for: str = Field(description="What the robot was waiting for at that moment; empty if it was not waiting.")
    waiting_since: float | None
    faults: tuple[str, ...] = Field(description="Faults that were active and may be related.")
    deadlock: bool = Field(description="Whether it was in a deadlock while it pursued the goal.")


class FaultSpan(_Model):
    """An injected fault, from its beginning to its end."""

    name: str
    fault: str
    subject: str = Field(description="The robot, door or lane that had it.")
    robot: str
    began: float
    ended: float | None
    detail: str


class Deadlock(_Model):
    """A cycle of robots of which each waited for the next."""

    at: float
    robots: tuple[str, ...]
    lanes: tuple[tuple[str, str], ...]


class Lane(_Model):
    """The usage of one direction of a lane; without names, of all segments off the lanes."""

    begin: str
    end: str
    drives: int
    distance: float
    seconds: float
    waits: int
    waited: float
    closed: float = Field(description="Seconds for which the lane was closed, in either direction.")


class Path(_Model):
    """A straight segment that was driven off the lanes, in either direction."""

    begin: tuple[float, float]
    end: tuple[float, float]
    drives: int


class Fixture(_Model):
    """The usage of a door, a lift or a dock."""

    name: str
    kind: Literal["door", "lift", "dock"]
    uses: int = Field(description="Openings of a door, trips of a lift, dockings at a dock.")
    robots: int = Field(description="Number of different robots that used it.")
    seconds: float = Field(description="Seconds for which it was open, moving, or occupied.")
    share: float = Field(description="The same as a share of the whole time.")
    waits: int = Field(description="How often a robot waited for it.")
    waited: float
    longest_queue: int | None = Field(description="Of a dock: the most robots that stood in its queue.")


class Delay(_Model):
    """The parts of an order's lead time, in simulated seconds; they add up to it."""

    assignment: float = Field(description="No robot has the order, or its robot has no goal.")
    travel: float = Field(description="Its robot drives.")
    handling: float = Field(description="Its robot picks up, places, or executes another goal where it stands.")
    queue: float = Field(description="Its robot stands in the queue of a dock.")
    charging: float = Field(description="Its robot is being charged.")
    traffic: float = Field(description="Its robot waits on its way, such as for other robots or a door.")
    faults: float = Field(description="Its robot is stopped or offline, or waits at a closed lane.")


class Order(_Model):
    """An order of the demand."""

    name: str
    item: str
    at: str = Field(description="Where the item was.")
    to: str = Field(description="Where it had to be brought.")
    priority: int
    state: str = Field(description="waiting, carried, delivered or lost, at the end.")
    robot: str = Field(description="Who has brought the item, or carries it; empty for nobody.")
    placed: float
    picked_up: float | None
    ended: float | None = Field(description="When it was delivered, or its item deleted.")
    lead_time: float | None = Field(description="Seconds from placing to delivery.")
    lateness: float = Field(description="Seconds after it was due, up to the delivery or the end; 0 if in time.")
    delay: Delay | None = Field(
        default=None, description="The parts of the lead time; null if it was not delivered, or motions are unknown."
    )


class Demand(_Model):
    """All orders of the demand."""

    placed: int
    delivered: int
    late: int = Field(description="Not delivered when they were due.")
    lost: int = Field(description="Whose item was deleted.")
    open: int = Field(description="At the end.")
    lead_time_mean: float | None
    lead_time_p50: float | None
    lead_time_p95: float | None
    lead_time_max: float | None
    delay: Delay | None = Field(default=None, description="The parts of `lead_time_mean`; null if they are unknown.")
    lateness_mean: float = Field(description="Of those that were late.")
    lateness_max: float
    backlog_mean: float = Field(description="Open orders, on average over time.")
    backlog_max: int


class Bucket(_Model):
    """The number of goals that ended in one interval."""

    began: float
    ended: float
    succeeded: int
    canceled: int
    aborted: int


class Report(_Model):
    """The report of one run."""

    report: Literal[1] = 1
    source: Source
    world: World
    summary: Summary
    robots: tuple[Robot, ...]
    goals: tuple[Goal, ...] = Field(description="In order of acceptance.")
    errors: tuple[Error, ...]
    waits: tuple[Wait, ...]
    first_causes: tuple[FirstCause, ...] = Field(default=(), description="The longest first.")
    states: tuple[Span, ...]
    faults: tuple[FaultSpan, ...]
    deadlocks: tuple[Deadlock, ...]
    lanes: tuple[Lane, ...]
    paths: tuple[Path, ...]
    fixtures: tuple[Fixture, ...]
    demand: Demand | None = Field(default=None, description="Null where there were no orders.")
    orders: tuple[Order, ...] = Field(default=(), description="In the order in which they came.")
    throughput: tuple[Bucket, ...]
    batteries: dict[str, tuple[tuple[float, float], ...]] = Field(description="Time and share, by robot; thinned.")
    events: dict[str, int] = Field(description="How often each kind of event was published.")


class Section(_Model):
    """A section of a trace, and its report."""

    section: int = Field(description="Its number, from 1.")
    cause: str = Field(
        description="Why it began: reset, time_reset (robots and items stayed where they were), stopped or"
        " world_loaded; empty for the first one."
    )
    report: Report


class Sections(_Model):
    """The reports of a trace with several sections, in each of which simulated time begins anew."""

    report: Literal[1] = 1
    sections: tuple[Section, ...]
