"""asyncio in lockstep: tasks run in the same order in each process, by simulated time."""

from __future__ import annotations

import asyncio
import gc
import os
import sys
import threading

import pytest

from hmrsim.testing import simulation
from hmrsim.trials.controllers import controller_of
from hmrsim.trials.trial import control
from hmrsim_zenoh import AsyncClient, Client, Deadlock
from hmrsim_zenoh.client.ordered_loop import OrderedLoop
from tests.torture.async_controllers import compare


def played(play):
    """Return the result of a coroutine function that gets a client of the café."""
    with simulation("cafe") as run:

        async def main():
            async with AsyncClient(run.client) as client:
                return await play(client)

        return asyncio.run(main())


def test_random_controllers_make_the_same_run_in_each_process():
    """The programs use many parts of asyncio, and some fail."""
    assert [] == compare(range(1, 21), 3, zenoh=False)


def test_random_controllers_make_the_same_run_over_zenoh():
    """The order is the same as within one process."""
    assert [] == compare(range(2001, 2004), 2, zenoh=True)


def test_tasks_are_ordered_as_they_were_made():
    """The event loop keeps tasks in sets."""

    async def play(client):
        started, closed = [], []

        async def work(number):
            started.append(number)
            try:
                await client.sleep(1)
            finally:
                closed.append(number)

        async def numbers(number):
            try:
                yield number
            finally:
                closed.append(number)

        for each in asyncio.as_completed([work(number) for number in range(50)]):
            await each
        tasks = [asyncio.create_task(work(number)) for number in range(50)]
        gathered = [asyncio.gather(client.sleep(1)) for _ in range(50)]
        asked = [each.get_name() for each in asyncio.all_tasks() if each in tasks]
        done, pending = await asyncio.wait(gathered, timeout=2)
        assert not pending
        generators = [numbers(number) for number in range(50)]
        for each in generators:
            await anext(each)
        del closed[:]
        await asyncio.get_running_loop().shutdown_asyncgens()
        return started, asked, [each.get_name() for each in tasks], [*done], gathered, closed

    started, asked, names, done, gathered, closed = played(play)

    assert [*range(50)] * 2 == started
    assert names == asked
    assert {*gathered} == {*done}
    assert [*range(50)] == closed


def test_the_clock_of_the_loop_is_simulated_time():
    """An hour takes no wall time, and a timeout counts simulated time."""

    async def play(client):
        await asyncio.sleep(3600)
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(3):
                await client.robot("mocha").wait(10)
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.Event().wait(), 0.5)
        return await client.now()

    assert 3603.5 == pytest.approx(played(play), abs=1e-6)


def test_garbage_is_collected_by_python_again_afterwards():
    """The client is closed by an error, too."""

    async def play(_client):
        assert not gc.isenabled()
        raise KeyError

    with pytest.raises(KeyError):
        played(play)

    assert gc.isenabled()


def test_a_deadlock_ends_the_program_at_once():
    """The error names each task and the place where it waits."""

    async def work(orders):
        while True:
            try:
                await orders.get()
            except Exception:  # noqa: BLE001 - a controller that goes on whatever happens
                continue

    async def play(client):
        orders = asyncio.Queue()
        await client.robot("mocha").wait(1)
        async with asyncio.TaskGroup() as tasks:
            for name in ("mocha", "latte"):
                tasks.create_task(work(orders), name=name)

    waiting = work.__code__.co_firstlineno + 3
    inside, queue = r"Task-.* waits in TaskGroup.__aexit__ \(.*test_ordered_loop.py:\d+\)", r"waits in Queue.get"
    with pytest.raises(
        Deadlock, match=rf"deadlock: no task .*{inside}; mocha {queue} \(.*:{waiting}\); latte {queue} \("
    ):
        played(play)


def test_a_deadlock_names_the_tasks_and_locks_for_which_others_wait():
    lock = asyncio.Lock()

    async def hold():
        async with lock:
            await asyncio.get_running_loop().create_future()

    async def acquire():
        async with lock:
            pass

    async def play(_client):
        holder = asyncio.create_task(hold(), name="holder")
        await asyncio.sleep(0)
        asyncio.create_task(acquire(), name="other").add_done_callback(lambda _task: None)
        await holder

    waits = (
        r"a file: other waits in Lock.acquire \(.*\) for a lock that holder holds; "
        r"Task-1 waits for holder \(.*; holder waits for a future \("
    )
    with pytest.raises(Deadlock, match=waits):
        played(play)


def test_a_deadlock_names_the_task_that_has_ended_with_a_lock_and_its_robot():
    async def hold(_robot, lock):
        await lock.acquire()

    async def retry(action, lock):
        await lock.acquire()
        await action("store")

    async def play(client):
        lock = asyncio.Lock()
        await asyncio.create_task(hold(client.robot("mocha"), lock))
        await asyncio.create_task(retry(client.robot("latte").navigate_to, lock), name="next")

    waits = r"next \(latte\) waits in Lock.acquire \(.*\) for a lock that Task-\d+ \(mocha\) holds, "
    with pytest.raises(Deadlock, match=rf"a file: {waits}which has ended without releasing it; Task-1 "):
        played(play)


def test_a_task_that_acquires_its_lock_again_waits_for_itself():
    async def play(_client):
        changed = asyncio.Condition()
        async with changed, changed:
            pass

    with pytest.raises(Deadlock, match=r"Task-1 waits in Lock.acquire \(.*\) for a lock that it holds itself"):
        played(play)


def test_a_deadlock_names_the_wait_of_code_without_a_module():
    code: dict[str, object] = {"asyncio": asyncio}
    exec("async def wait(_client):\n    await asyncio.Event().wait()", code)

    with pytest.raises(Deadlock, match=r"Task-1 waits in Event.wait \("):
        played(code["wait"])


def test_the_text_of_a_deadlock_is_the_same_in_each_run():
    """The names that asyncio gives count the tasks of the process; `asyncio.run` makes the first before a client."""

    async def play(_client):
        await asyncio.gather(*(asyncio.Event().wait() for _ in range(2)))

    texts = []
    for _ in range(2):
        with pytest.raises(Deadlock) as deadlock:
            played(play)
        texts.append(str(deadlock.value))

    assert texts[0] == texts[1]
    assert "Task-1 " in texts[0]


def test_what_tasks_ask_the_simulator_is_answered_in_the_order_in_which_they_ask(monkeypatch):
    """Over a network, answers arrive in any order; here, too, if each question has a thread of its own."""
    asked: list[tuple[str, str]] = []

    def pose_of(_client, name):
        asked.append((name, threading.current_thread().name))
        if name == "nobody":
            raise KeyError(name)
        return name

    async def play(client):
        robots = ("mocha", "nobody", "latte", "chai")
        return await asyncio.gather(*(client.robot(name).pose() for name in robots), return_exceptions=True)

    monkeypatch.setattr(Client, "pose_of", pose_of)
    mocha, error, *others = played(play)

    assert ("mocha", KeyError, ["latte", "chai"]) == (mocha, type(error), others)
    assert ["mocha", "nobody", "latte", "chai"] == [name for name, _ in asked]
    assert len({thread for _, thread in asked}) == 1


def test_what_waits_for_a_thread_is_no_deadlock():
    """The thread belongs to an executor or to the user."""

    async def play(_client):
        loop, event = asyncio.get_running_loop(), asyncio.Event()
        may_go_on = threading.Event()
        loop.call_later(1, may_go_on.set)
        await asyncio.to_thread(may_go_on.wait)
        thread = threading.Thread(target=lambda: may_go_on.wait() and loop.call_soon_threadsafe(event.set))
        may_go_on.clear()
        thread.start()
        loop.call_later(1, may_go_on.set)
        await event.wait()
        return "woken"

    assert "woken" == played(play)


def test_what_waits_for_a_file_is_no_deadlock():
    """The task waits for a pipe or a process."""

    async def play(_client):
        loop, event = asyncio.get_running_loop(), asyncio.Event()
        reading, writing = os.pipe()
        loop.add_reader(reading, event.set)
        os.write(writing, b"x")
        await event.wait()
        loop.remove_reader(reading)
        process = await asyncio.create_subprocess_exec(sys.executable, "-c", "")
        return await process.wait()

    assert 0 == played(play)


def test_a_deadlock_is_an_ending_of_its_own(tmp_path):
    """The run of an experiment ends with the cause."""
    (tmp_path / "waits_for_ever.py").write_text(
        "import asyncio\n\nasync def go(client):\n    await asyncio.Event().wait()\n"
    )

    class Treatment:
        set, tree, python, robots = {}, None, "waits_for_ever.py:go", None

    with simulation("cafe") as run:
        ending, cause = control(controller_of(Treatment, {}, tmp_path), run.client, run.simulator)

    assert "deadlock" == ending
    assert "waits_for_ever.py:4" in cause


def test_a_loop_of_another_kind_stays_as_it_is():
    class Other(asyncio.SelectorEventLoop):
        pass

    loop = Other()
    try:
        assert OrderedLoop.of(loop) is None
        assert type(loop) is Other
    finally:
        loop.close()
