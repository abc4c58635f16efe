"""What a goal costs over the wire, against the bare round trip of a Zenoh query between the same two processes.

All variants take turns, round by round, so that a busy moment of the machine meets each of them.
"""

from __future__ import annotations

import json
import multiprocessing
import statistics
import time
from pathlib import Path
from typing import TYPE_CHECKING

import zenoh

from hmrsim.world import LoadedWorld
from hmrsim.world.model import World
from hmrsim_zenoh.host import Host, HostSettings
from hmrsim_zenoh.session import SessionOptions

if TYPE_CHECKING:
    from collections.abc import Callable
    from multiprocessing.connection import Connection

ROUNDS = 300
_GOAL = json.dumps({"goal": {}}).encode()


def _serve(pipe: Connection) -> None:
    """Serve one robot as fast as possible, and a bare queryable beside it, until told to end."""
    world = World.model_validate({"robots": {"wall_e": {"at": [0, 0]}}})
    loaded = LoadedWorld(world=world, path=Path("benchmark"), warnings=(), hash="")
    settings = HostSettings(real_time_factor=0.0, keep_results=10)
    with Host(loaded, SessionOptions(listen=("tcp/127.0.0.1:0",)), settings) as host:
        host.start()
        host._session.declare_queryable(  # noqa: SLF001 - the bare queryable must share the session
            "bare/*", zenoh.handlers.Callback(lambda query: query.reply(query.key_expr, b"{}"), indirect=False)
        )
        pipe.send(host.endpoints[0])
        pipe.recv()


def _ask(session: zenoh.Session, key: str, payload: bytes) -> bytes:
    for reply in session.get(key, payload=payload, timeout=30):
        if reply.ok is not None:
            return bytes(reply.ok.payload.to_bytes())
    raise RuntimeError(f"no answer on {key}")


def _variants(session: zenoh.Session) -> dict[str, Callable[[int], None]]:
    keys = {verb: f"hmrsim/wall_e/wait/_action/{verb}" for verb in ("send_goal", "get_result")}

    def bare(_number: int) -> None:
        _ask(session, "bare/x", b"{}")

    def info(_number: int) -> None:
        _ask(session, "hmrsim/_world/info", b"")

    def accepted(_number: int) -> None:
        _ask(session, keys["send_goal"], _GOAL)

    def one_by_one(_number: int) -> None:
        answer = json.loads(_ask(session, keys["send_goal"], _GOAL))
        _ask(session, keys["get_result"], json.dumps({"goal_id": answer["goal_id"]}).encode())

    def right_behind(number: int) -> None:
        goal_id = f"{number + 1:032x}"
        sent = session.get(keys["send_goal"], payload=json.dumps({"goal_id": goal_id, "goal": {}}), timeout=30)
        _ask(session, keys["get_result"], json.dumps({"goal_id": goal_id}).encode())
        for _ in sent:
            pass

    return {
        "bare get": bare,
        "_world/info": info,
        "send_goal to accepted": accepted,
        "goal to result, one by one": one_by_one,
        "goal to result, get_result right behind": right_behind,
    }


def run() -> list[tuple[str, str, str]]:
    """Return a row a variant: its name, its median in microseconds, and its ratio to the bare query."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    server = context.Process(target=_serve, args=(there,))
    server.start()
    there.close()  # so that a server that dies is the end of the pipe
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([here.recv()]))
    taken: dict[str, list[float]] = {}
    with zenoh.open(config) as session:
        variants = _variants(session)
        for number in range(ROUNDS):
            for name, variant in variants.items():
                begun = time.perf_counter()
                variant(number)
                taken.setdefault(name, []).append(time.perf_counter() - begun)
    here.send("end")
    server.join(10)
    medians = {name: statistics.median(times) for name, times in taken.items()}
    bare = medians["bare get"]
    return [(name, f"{median * 1e6:.0f} us", f"{median / bare:.2f}x") for name, median in medians.items()]
