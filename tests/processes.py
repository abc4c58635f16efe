"""Our programs as processes that are forked from one with everything imported, which saves half a second each.

How the programs start is tested where they are started as users start them.
"""

from __future__ import annotations

import atexit
import json
import os
import select
import socket
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from tests.paths import ROOT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_PROGRAMS: Final = ("hmrsim", "bt-controller")
_BEFORE_IMPORTS: Final = frozenset({"PYTHONHASHSEED", "PYTHONPATH"})
"""Variables that Python reads when it starts, so that a forked process would ignore them."""
_SERVER: Final = "import sys; from tests.processes import serve; sys.exit(serve(int(sys.argv[1])))"


def start(program: str, *arguments: object, **options: Any) -> subprocess.Popen[str]:
    """Start ``hmrsim`` or ``bt-controller``, as `subprocess.Popen` would: text, with pipes for what it writes."""
    words = [program, *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "stdin": subprocess.DEVNULL, "text": True}
    env = options.get("env") or os.environ
    if program in _PROGRAMS and not _BEFORE_IMPORTS & env.keys():
        return _Forked(words, **{**pipes, **options})
    return subprocess.Popen([Path(sys.executable).with_name(program), *words[1:]], **{**pipes, **options})


@contextmanager
def killed_at_the_end() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Yield the function that starts ``hmrsim``; processes that still run at the end are killed."""
    with ExitStack() as stack:

        def run(*arguments: object) -> subprocess.Popen[str]:
            process = stack.enter_context(start("hmrsim", *arguments))
            stack.callback(process.kill)
            return process

        yield run


class _Forked(subprocess.Popen[str]):
    """A grandchild with the interface of a child; another process waits for it and reports its exit code."""

    def _execute_child(self, args: list[str], *rest: Any) -> None:
        cwd, env = rest[4], rest[5]
        child_in, _, _, child_out, _, child_err = rest[9:15]
        reader, writer = os.pipe()
        self._ended = os.fdopen(reader)
        order = {"argv": args, "cwd": os.fspath(cwd or Path.cwd()), "env": dict(env or os.environ)}
        own = [default if one == -1 else one for default, one in enumerate((child_in, child_out, child_err))]
        socket.send_fds(_server()[0], [json.dumps(order).encode()], [*own, writer])
        os.close(writer)
        self.pid = int(self._ended.readline())
        self._child_created = True
        self._close_pipe_fds(*rest[9:15])

    def _try_wait(self, wait_flags: int) -> tuple[int, int]:
        if wait_flags & os.WNOHANG and not select.select([self._ended], [], [], 0)[0]:
            return 0, 0
        with self._ended:
            return self.pid, int(self._ended.readline())

    def _internal_poll(self, *_: Any, **__: Any) -> int | None:
        with self._waitpid_lock:
            if self.returncode is None:
                pid, status = self._try_wait(os.WNOHANG)
                if pid:
                    self._handle_exitstatus(status)
        return self.returncode


@cache
def _server() -> tuple[socket.socket, subprocess.Popen[bytes]]:
    """Return the socket for requests to the server, and the server, which ends with this process."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
    words = [sys.executable, "-c", _SERVER, str(theirs.fileno())]
    server = subprocess.Popen(words, cwd=ROOT, pass_fds=[theirs.fileno()], stdout=subprocess.DEVNULL)
    theirs.close()
    for end in (ours.close, server.wait, server.kill):  # the last one first
        atexit.register(end)
    return ours, server


def serve(descriptor: int) -> int:
    """Start each requested program in a separate process, which returns from here with its exit code."""
    programs = _loaded()
    orders = socket.socket(fileno=descriptor)
    while True:
        data, given, _, _ = socket.recv_fds(orders, 1 << 20, 4)
        if not data:
            return 0
        if not os.fork():
            orders.close()
            order = json.loads(data)
            _become(order, given)
            return programs[order["argv"][0]]()
        for one in given:
            os.close(one)


def _loaded() -> dict[str, Callable[[], int]]:
    """Return the main functions of the programs after loading their dependencies."""
    # Only the server needs these slow imports.
    import bt_controller.__main__  # noqa: PLC0415
    import bt_controller.cli._watching  # noqa: PLC0415
    import bt_controller.running.runner  # noqa: PLC0415
    import hmrsim.cli  # noqa: PLC0415
    import hmrsim.cli.event_log  # noqa: PLC0415
    import hmrsim.cli.goal_text  # noqa: PLC0415
    import hmrsim.cli.names  # noqa: PLC0415
    import hmrsim.cli.replay  # noqa: PLC0415
    import hmrsim.cli.run  # noqa: PLC0415
    from hmrsim.simulation.simulator import Simulator  # noqa: PLC0415
    from hmrsim.world_checks import load_world  # noqa: PLC0415

    Simulator(load_world("scenario1").world)
    return {"hmrsim": hmrsim.cli.main, "bt-controller": bt_controller.__main__.main}


def _become(order: dict[str, Any], given: list[int]) -> None:
    """Fork into the requested process; the parent reports its process id and its exit code."""
    *own, teller = given
    if child := os.fork():
        for one in own:
            os.close(one)
        os.write(teller, f"{child}\n".encode())
        os.write(teller, str(os.waitpid(child, 0)[1]).encode())
        os._exit(0)
    for number, one in enumerate(own):
        os.dup2(one, number)
    os.closerange(3, teller + 1)
    os.chdir(order["cwd"])
    os.environ.clear()
    os.environ.update(order["env"])
    if os.environ.get("PYTHONUNBUFFERED"):
        sys.stdout.reconfigure(write_through=True)
    sys.argv = order["argv"]
