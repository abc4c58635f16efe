"""Ctrl-C and SIGTERM while a behavior does not return."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from bt_controller.cli.run import on_interrupt

BLOCKED = """\
import os, signal, time
from bt_controller.cli import run

if {twice}:
    run._STOP_SECONDS = 1000

def stop():
    print("stop", flush=True)
    if {twice}:
        os.kill(os.getpid(), {number})

with run.on_interrupt(stop, lambda: print("give up", flush=True)):
    os.kill(os.getpid(), {number})
    time.sleep(1000)
"""


def blocked(number, *, twice):
    """Return exit code and output of a process whose main thread blocks when it gets a signal."""
    program = BLOCKED.format(number=int(number), twice=twice)
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    return ended.returncode, ended.stdout


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_what_blocks_is_given_up(number, code):
    assert blocked(number, twice=False) == (code, "stop\ngive up\n")


def test_a_second_signal_does_not_wait():
    assert blocked(signal.SIGINT, twice=True) == (130, "stop\ngive up\n")


def test_the_handlers_are_put_back():
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with on_interrupt(lambda: None, lambda: None) as numbers:
        pass

    assert numbers == []
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
    assert signal.set_wakeup_fd(-1) == -1


def test_other_signals_are_not_meant():
    """A tree may have a handler for one."""
    heard = []
    before = signal.signal(signal.SIGUSR1, lambda number, _frame: heard.append(number))
    with on_interrupt(lambda: heard.append("stop"), lambda: None):
        signal.raise_signal(signal.SIGUSR1)
    signal.signal(signal.SIGUSR1, before)

    assert heard == [signal.SIGUSR1]


def test_ctrl_c_while_modules_load_is_130():
    program = (
        "import os, signal, sys; from bt_controller.__main__ import main; "
        "sys.addaudithook(lambda event, _: event == 'import' and os.kill(os.getpid(), signal.SIGINT)); "
        "sys.exit(main())"
    )

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)

    assert (130, "") == (done.returncode, done.stderr)
