"""Signal handlers of programs and commands."""

import queue
import signal
import threading

import pytest

from hmrsim.program.signals import SIGNALS, on_signals
from tests.patience import PATIENCE


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_wakes_the_waiting_main_thread(number):
    heard: queue.SimpleQueue[int] = queue.SimpleQueue()
    waits = threading.Event()

    def send() -> None:
        waits.wait()
        signal.pthread_kill(threading.get_ident(), number)

    with on_signals(heard.put):
        threading.Thread(target=send).start()
        waits.set()

        assert number == heard.get(timeout=PATIENCE)


def test_the_inner_handler_replaces_the_outer():
    outer: queue.SimpleQueue[int] = queue.SimpleQueue()
    inner: queue.SimpleQueue[int] = queue.SimpleQueue()
    with on_signals(outer.put):
        with on_signals(inner.put):
            signal.raise_signal(signal.SIGTERM)
        assert signal.SIGTERM == inner.get_nowait()
        assert outer.empty()

        signal.raise_signal(signal.SIGINT)
    assert signal.SIGINT == outer.get_nowait()


def test_handlers_are_restored():
    before = [signal.getsignal(number) for number in SIGNALS]
    with on_signals(lambda _number: None):
        pass

    assert [signal.getsignal(number) for number in SIGNALS] == before
    assert signal.set_wakeup_fd(-1) == -1
