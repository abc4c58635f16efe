"""A fake simulator that follows a script, loses chosen messages, and dies on command."""

from __future__ import annotations

import json
import threading
from collections import defaultdict
from typing import TYPE_CHECKING, Any

import pytest
import zenoh

from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.wire.keys import Keys, Verb
from hmrsim_zenoh.wire.session import SessionOptions, open_server
from tests.listened import Listened
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


Body = dict[str, Any]
Step = Any
STAMP = {"sec": 1, "nanosec": 0}


class FakeSimulator:
    """Answers requests by a script: each verb has its steps; the last one is repeated.

    A step is what is done with a request, a function of the query and its body; without one it is held.

    Attributes:
        inform: The step of all requests for ``_world/info``, which are not among `requests`.
    """

    def __init__(self, *, endpoint: str = "tcp/127.0.0.1:0", present: bool = True) -> None:
        self.keys = Keys()
        self.session, (self.endpoint,) = open_server(SessionOptions(listen=(endpoint,)))
        self.requests: list[tuple[str, Body]] = []
        self.steps: dict[str, list[Step]] = defaultdict(list)
        self._held: list[tuple[zenoh.Query, Body]] = []
        self._changed = threading.Condition()
        self._listened = Listened(self.session)
        handler = zenoh.handlers.Callback(self._on_query, indirect=False)
        self._queryable = self.session.declare_queryable(
            self.keys.action("*", "*", Verb.SEND_GOAL).rpartition("/")[0] + "/*", handler, complete=True
        )
        self.inform: Step = self.say({"clock": "realtime"})
        self._described = self.session.declare_queryable(
            self.keys.world("info"), zenoh.handlers.Callback(lambda query: self.inform(query, None), indirect=False)
        )
        self._token = self.session.liveliness().declare_token(self.keys.alive()) if present else None

    # --- steps ---

    def accept(self, query: zenoh.Query, body: Body) -> None:
        answer = {"accepted": True, "goal_id": body["goal_id"], "stamp": STAMP}
        query.reply(query.key_expr, json.dumps(answer))

    def lose(self, query: zenoh.Query, body: Body) -> None:
        """Accept the request without a reply, as when the reply is lost."""

    def hold(self, query: zenoh.Query, body: Body) -> None:
        self._held.append((query, body))

    def canceling(self, query: zenoh.Query, body: Body) -> None:
        """Answer that the goal is being canceled."""
        info = {"goal_id": body["goal_info"]["goal_id"], "stamp": STAMP}
        query.reply(query.key_expr, json.dumps({"return_code": 0, "goals_canceling": [info]}))

    def refuse(self, reason: str, status: int | None = None) -> Step:

        def step(query: zenoh.Query, body: Body) -> None:
            answer = {"accepted": False, "goal_id": body["goal_id"], "stamp": STAMP, "error_code": 1}
            answer |= {"reason": reason, "error_msg": f"because of {reason}"}
            query.reply(query.key_expr, json.dumps(answer | ({} if status is None else {"status": status})))

        return step

    def say(self, body: Body) -> Step:
        return lambda query, _body: query.reply(query.key_expr, json.dumps(body))

    def say_error(self, payload: str) -> Step:
        return lambda query, _body: query.reply_err(payload)

    def both(self, first: Step, second: Step) -> Step:

        def step(query: zenoh.Query, body: Body) -> None:
            first(query, body)
            second(query, body)

        return step

    def end(self, status: int, **result: object) -> Step:
        """Answer that the goal has ended so."""
        return self.say({"status": status, "result": result})

    # --- what the test does ---

    def release(self, step: Step, *, verb: Verb) -> None:
        """Do this with the held requests of a verb."""
        with self._changed:
            due = [item for item in self._held if str(item[0].key_expr).endswith(verb.value)]
            self._held = [item for item in self._held if item not in due]
        for query, body in due:
            step(query, body)

    def wait_for(self, verb: Verb, count: int = 1) -> list[Body]:
        """Wait until *count* requests of a verb have come; return all of them."""

        def bodies() -> list[Body]:
            return [body for name, body in self.requests if name == verb.value]

        with self._changed:
            assert self._changed.wait_for(lambda: len(bodies()) >= count, PATIENCE), self.requests
            return bodies()

    def count(self, verb: Verb) -> int:
        """Return how many requests of a verb have come so far."""
        return sum(name == verb.value for name, _ in self.requests)

    def vanish(self) -> None:
        """Undeclare the token, but go on holding what is held: a simulator that hangs."""
        assert self._token is not None
        self._token.undeclare()

    def publish_feedback(self, key: str, payload: str) -> None:
        self.session.put(key, payload)

    def has_subscriber(self, key: str) -> bool:
        """Return whether a key has a subscriber."""
        return self._listened.now(key)

    def wait_for_subscriber(self, key: str, *, there: bool) -> None:
        self._listened.wait(key, there=there)

    def close(self) -> None:
        self._held.clear()
        self.session.close()

    def _on_query(self, query: zenoh.Query) -> None:
        verb = str(query.key_expr).rpartition("/")[2]
        body = json.loads(query.payload.to_bytes() if query.payload else b"null")
        steps = self.steps[verb]
        step = steps.pop(0) if len(steps) > 1 else steps[0] if steps else self.hold
        with self._changed:
            self.requests.append((verb, body))
            step(query, body)
            self._changed.notify_all()


class Watched:
    """Collects what callbacks bring; `wait` waits for it."""

    def __init__(self) -> None:
        self.items: list[Any] = []
        self._changed = threading.Condition()

    def __call__(self, *item: Any) -> None:
        with self._changed:
            self.items.append(item[0] if len(item) == 1 else item)
            self._changed.notify_all()

    def wait(self, until: Callable[[list[Any]], bool]) -> list[Any]:
        """Wait until this is true of the items; return them."""
        with self._changed:
            assert self._changed.wait_for(lambda: until(self.items), PATIENCE), self.items
            return list(self.items)


@pytest.fixture
def simulator() -> Iterator[FakeSimulator]:
    """A fake simulator that accepts every goal and holds its result; like some robots, it does not know `execute`."""
    fake = FakeSimulator()
    fake.steps["send_goal"] = [fake.accept]
    fake.steps["execute"] = [fake.lose]
    try:
        yield fake
    finally:
        fake.close()


@pytest.fixture
def another() -> Iterator[Callable[..., FakeSimulator]]:
    """Make further fake simulators; closed at the end."""
    made: list[FakeSimulator] = []

    def make(**options: Any) -> FakeSimulator:
        made.append(FakeSimulator(**options))
        return made[-1]

    yield make
    for fake in made:
        fake.close()


@pytest.fixture
def client(simulator: FakeSimulator) -> Iterator[Client]:
    """A client of the fake simulator, with little patience."""
    with Client(SessionOptions(connect=(simulator.endpoint,)), acknowledge_timeout=2.0, grace=0.3) as client:
        yield client


@pytest.fixture
def watched() -> Watched:
    return Watched()
