"""Random asyncio controllers that fail at random moments: each makes the same run in every process.

::

    python -m tests.torture.async_controllers --count 1000 --processes 5
    python -m tests.torture.async_controllers --count 100 --zenoh

Each process has another hash seed, other addresses in memory, and collects garbage at other moments.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import hashlib
import logging
import os
import random
import subprocess
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import HmrsimError
from hmrsim.settings.run import RunSettings
from hmrsim.trace.writer import Header, Trace
from hmrsim.world.overlays.overlay import setting
from hmrsim.world_checks import load_world
from hmrsim_zenoh import AsyncClient, Client, SessionOptions
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine, Sequence

    from hmrsim.world_checks import LoadedWorld

PLACES: Final = ("table_1", "table_2", "table_3", "table_4", "counter", "hall", "terrace", "nowhere")
ROBOTS: Final = ("mocha", "latte", "chai")
ORDERS: Final = "demand.+={name: order, item: cup, at: counter, to: [table_1, table_2], arrives: 13}"

_SETTINGS: Final = RunSettings(clock="lockstep", duration=200.0)
_MOST_STEPS: Final = 120
_DEEPEST: Final = 4


class Controller:
    """A controller that acts at random, and records the outcomes."""

    def __init__(self, client: AsyncClient, seed: int) -> None:
        self.log: list[Any] = []
        self._client = client
        self._chance = random.Random(seed)
        self._steps = 0
        self._background: set[asyncio.Task[None]] = set()
        self._cycles: list[Any] = []
        self._queue: asyncio.Queue[int] = asyncio.Queue(3)
        self._lock, self._event, self._condition = asyncio.Lock(), asyncio.Event(), asyncio.Condition()
        self._semaphore, self._barrier = asyncio.Semaphore(2), asyncio.Barrier(2)
        self._kinds = [
            *[self._goal] * 6,
            *[self._sleep] * 3,
            *[self._ask] * 3,
            *[self._group] * 3,
            self._gather,
            self._wait,
            self._wait_for_groups,
            self._as_completed,
            self._timeout,
            self._shield,
            self._fail,
            self._put,
            self._get,
            self._locked,
            self._signal,
            self._notified,
            self._meet,
            self._generate,
            self._forget,
            self._start,
            self._cancel_some,
            self._cancel_all,
            self._listen,
        ]

    async def run(self) -> None:
        for _ in range(self._chance.randint(1, 4)):
            await self._group(0)

    def end(self) -> list[Any]:
        """End everything; return the record."""
        self._steps = _MOST_STEPS
        return [*self.log]

    async def _work(self, depth: int) -> None:
        name = asyncio.current_task()
        try:
            for _ in range(self._chance.randint(1, 4)):
                self._steps += 1
                if self._steps > _MOST_STEPS:
                    return
                kind = self._chance.choice(self._kinds if depth < _DEEPEST else [self._goal, self._sleep, self._fail])
                self.log.append((name and name.get_name(), kind.__name__, await self._client.now()))
                with suppress(TimeoutError):
                    await kind(depth + 1)
        except (HmrsimError, KeyError) as error:
            self.log.append((type(error).__name__, str(error)))
            if self._chance.random() < 0.5:
                raise
        finally:
            self.log.append(("ends", self._chance.random()))
            if self._chance.random() < 0.1:
                await asyncio.sleep(0)

    def _some(self, depth: int) -> list[Coroutine[Any, Any, None]]:
        return [self._work(depth) for _ in range(self._chance.randint(2, 4))]

    def _seconds(self) -> float:
        return self._chance.choice([0.0, 0.001, 0.5, 1.0, 3.0, self._chance.uniform(0, 10)])

    async def _goal(self, _depth: int) -> None:
        robot = self._client.robot(self._chance.choice(ROBOTS))
        match self._chance.randrange(5):
            case 0:
                await robot.navigate_to(self._chance.choice(PLACES[:-1]))
            case 1:
                await robot.wait(self._seconds())
            case 2:
                await robot.spin(self._chance.uniform(-3, 3), on_feedback=lambda _: self.log.append("feedback"))
            case 3:
                await robot.pickup(self._chance.choice(["cup_1", "moon"]))
            case _:
                await robot.undock()

    async def _ask(self, _depth: int) -> None:
        robot = self._client.robot(self._chance.choice((*ROBOTS, "nobody")))
        match self._chance.randrange(3):
            case 0:
                self.log.append(await robot.pose())
            case 1:
                self.log.append([robot["name"] for robot in (await self._client.info())["robots"]])
            case _:
                await robot.battery()

    async def _sleep(self, _depth: int) -> None:
        if self._chance.random() < 0.5:
            await asyncio.sleep(self._seconds())
        else:
            await self._client.sleep(self._seconds())

    async def _fail(self, _depth: int) -> None:
        await asyncio.sleep(0)
        raise KeyError(self._chance.random())

    async def _group(self, depth: int) -> None:
        try:
            async with asyncio.TaskGroup() as group:
                for work in self._some(depth):
                    group.create_task(work)
        except* (HmrsimError, KeyError) as errors:
            self.log.append([str(each) for each in errors.exceptions])

    async def _gather(self, depth: int) -> None:
        await asyncio.gather(*self._some(depth), return_exceptions=self._chance.random() < 0.7)

    async def _wait(self, depth: int) -> None:
        when = self._chance.choice([asyncio.FIRST_COMPLETED, asyncio.FIRST_EXCEPTION, asyncio.ALL_COMPLETED])
        tasks = [asyncio.create_task(each) for each in self._some(depth)]
        await self._settle(*await asyncio.wait(tasks, timeout=self._seconds(), return_when=when))

    async def _wait_for_groups(self, depth: int) -> None:
        gathered = [asyncio.gather(*self._some(depth), return_exceptions=True) for _ in range(3)]
        await self._settle(*await asyncio.wait(gathered, timeout=self._seconds(), return_when=asyncio.FIRST_COMPLETED))

    async def _settle(self, done: set[Any], pending: set[Any]) -> None:
        for each in done:
            with suppress(HmrsimError, KeyError, asyncio.CancelledError):
                self.log.append(each.result())
        for each in pending:
            each.cancel()
        await asyncio.gather(*pending, return_exceptions=True)

    async def _as_completed(self, depth: int) -> None:
        for each in asyncio.as_completed(self._some(depth), timeout=self._seconds() + 1.0):
            with suppress(HmrsimError, KeyError):
                await each

    async def _timeout(self, depth: int) -> None:
        if self._chance.random() < 0.5:
            async with asyncio.timeout(self._seconds()):
                await self._work(depth)
        else:
            await asyncio.wait_for(self._work(depth), self._seconds())

    async def _shield(self, depth: int) -> None:
        task = asyncio.create_task(self._work(depth))
        self._background.add(task)
        async with asyncio.timeout(self._seconds()):
            await asyncio.shield(task)

    async def _put(self, _depth: int) -> None:
        async with asyncio.timeout(self._seconds()):
            await self._queue.put(self._steps)

    async def _get(self, _depth: int) -> None:
        async with asyncio.timeout(self._seconds()):
            self.log.append(await self._queue.get())

    async def _locked(self, depth: int) -> None:
        async with asyncio.timeout(20.0), self._chance.choice([self._lock, self._semaphore]):
            await self._sleep(depth)

    async def _signal(self, _depth: int) -> None:
        if self._chance.random() < 0.5:
            self._event.set()
        else:
            self._event.clear()
            async with asyncio.timeout(self._seconds()):
                await self._event.wait()

    async def _notified(self, _depth: int) -> None:
        async with asyncio.timeout(self._seconds()), self._condition:
            if self._chance.random() < 0.5:
                self._condition.notify_all()
            else:
                await self._condition.wait()

    async def _meet(self, _depth: int) -> None:
        try:
            async with asyncio.timeout(self._seconds() + 1.0):
                self.log.append(await self._barrier.wait())
        except asyncio.BrokenBarrierError:
            await self._barrier.reset()

    async def _numbers(self, count: int) -> AsyncIterator[int]:
        try:
            for number in range(count):
                await asyncio.sleep(self._seconds())
                yield number
        finally:
            self.log.append(("closed", count, self._chance.random()))
            await asyncio.sleep(0)

    async def _generate(self, _depth: int) -> None:
        numbers = self._numbers(self._chance.randint(1, 9))
        cycle: list[Any] = [numbers]
        match self._chance.randrange(3):
            case 0:
                # Nobody but the collector of garbage can find it.
                cycle.append(cycle)
            case 1:
                self._cycles.append(numbers)
        async for number in numbers:
            if number == 1:
                break

    async def _forget(self, depth: int) -> None:
        """Start a task without keeping a reference to it."""

        async def wait() -> None:
            try:
                await asyncio.get_running_loop().create_future()
            finally:
                self.log.append(("forgotten", self._chance.random()))

        asyncio.create_task(wait())  # noqa: RUF006 - that is the point
        await self._sleep(depth)

    async def _start(self, depth: int) -> None:
        for work in self._some(depth):
            task = asyncio.create_task(work)
            self._background.add(task)
            task.add_done_callback(self._background.discard)

    async def _cancel_some(self, _depth: int) -> None:
        for task in list(self._background):
            if self._chance.random() < 0.5:
                task.cancel()

    async def _cancel_all(self, _depth: int) -> None:
        if self._chance.random() < 0.3:
            for task in asyncio.all_tasks() - {asyncio.current_task()}:
                if self._chance.random() < 0.3 and task.get_name() != "main":
                    task.cancel()

    async def _listen(self, depth: int) -> None:
        async for event in self._client.events("order_placed", "status"):
            self.log.append((event["kind"], await self._client.now()))
            if self._chance.random() < 0.5:
                break
            await self._sleep(depth)


async def _controlled(client: AsyncClient, seed: int, log: list[Any]) -> None:
    task = asyncio.current_task()
    if task is not None:
        task.set_name("main")
    async with client:
        controller = Controller(client, seed)
        try:
            await controller.run()
        finally:
            # Tasks that outlive the client go on by the clock of the machine.
            log.extend(controller.end())


def _ending(client: AsyncClient, seed: int, log: list[Any]) -> str:
    try:
        asyncio.run(_controlled(client, seed, log))
    except (Exception, SystemExit, asyncio.CancelledError) as error:  # noqa: BLE001 - whatever it is
        return f"{type(error).__name__}: {error}"
    return "ended"


def played(loaded: LoadedWorld, seed: int, *, zenoh: bool = False) -> str:
    """Return the trace, the record and the end of a random controller, as lines."""
    pieces: list[str] = []
    log: list[Any] = []
    settings = _SETTINGS.model_copy(update={"seed": seed})
    trace = Trace(Header.of(loaded.world, settings), pieces.append)
    if zenoh:
        listen = SessionOptions(listen=("tcp/127.0.0.1:0",))
        with Host(loaded, listen, settings, sinks=[trace]) as host:
            host.start()
            options = SessionOptions(connect=(host.endpoints[0],))
            ending = _ending(AsyncClient(options=options, name="dispatcher"), seed, log)
        now = host.simulator.now
    else:
        with LoopbackHost(loaded.world, settings, sinks=[trace]) as local:
            with Client(session=local.open_session(), name="dispatcher") as client:
                ending = _ending(AsyncClient(client), seed, log)
            now = local.simulator.now
    trace.close(now)
    return "\n".join(["".join(pieces), *map(repr, log), ending])


def world() -> LoadedWorld:
    return load_world("cafe", overlays=[setting(ORDERS)])


def digests(seeds: Sequence[int], number: int, *, zenoh: bool) -> None:
    """Print the digest of each run, in a process that differs from others by its number."""
    logging.disable()
    chance = random.Random(number)
    gc.set_threshold(chance.randint(50, 2000))
    junk: list[Any] = [bytearray(chance.randint(1, 500)) for _ in range(chance.randint(1, 20_000))]
    loaded = world()
    for seed in seeds:
        junk.append([object() for _ in range(chance.randint(1, 500))])
        del junk[: chance.randint(0, len(junk) // 10)]
        text = played(loaded, seed, zenoh=zenoh)
        ending = text.rsplit("\n", 1)[-1]
        sys.stdout.write(f"{seed} {hashlib.sha256(text.encode()).hexdigest()} {text.count(chr(10))} {ending[:80]}\n")
        sys.stdout.flush()


def compare(seeds: Sequence[int], processes: int, *, zenoh: bool) -> list[tuple[str, ...]]:
    """Return the lines of the controllers whose runs differ between processes."""
    words = ["--seed", str(seeds[0]), "--count", str(len(seeds)), *(["--zenoh"] if zenoh else [])]
    told = []
    for number in range(processes):
        command = [sys.executable, "-m", __spec__.name, *words, "--as", str(number)]
        environment = {**os.environ, "PYTHONHASHSEED": str(number + 1)}
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
        told.append(done.stdout.splitlines())
    return [lines for lines in zip(*told, strict=True) if len(set(lines)) > 1]


def main() -> int:
    """Compare many controllers; print those whose runs differ."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=5)
    parser.add_argument("--zenoh", action="store_true", help="over Zenoh")
    parser.add_argument("--as", dest="number", type=int, help="print the digests of one process")
    args = parser.parse_args()
    seeds = range(args.seed, args.seed + args.count)
    if args.number is not None:
        digests(seeds, args.number, zenoh=args.zenoh)
        return 0
    began = time.monotonic()
    differ = compare(seeds, args.processes, zenoh=args.zenoh)
    for lines in differ:
        sys.stdout.write("\n".join(["differs:", *lines, ""]))
    seconds = time.monotonic() - began
    sys.stdout.write(f"{args.count} controllers, {args.processes} processes, {seconds:.0f} s: {len(differ)} differ\n")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
