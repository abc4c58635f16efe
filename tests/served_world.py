"""A world that the test process serves over Zenoh, for clients that need a real simulator."""

from __future__ import annotations

from contextlib import contextmanager
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from hmrsim.settings.run import RunSettings
from hmrsim.world import World
from hmrsim.world_checks import world_hash
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.session import SessionOptions
from tests.simulation import SMALL_WORLD

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hmrsim.protocol.sinks import Sink
    from hmrsim_zenoh.ros2.wires import Wire


_ANYWHERE = SessionOptions(listen=("tcp/127.0.0.1:0",))


@contextmanager
def served_world(
    world: object = None,
    *,
    options: SessionOptions = _ANYWHERE,
    wires: Sequence[Wire] = (),
    sinks: Sequence[Sink] = (),
    **settings: Any,
) -> Iterator[SessionOptions]:
    """Serve a world, the small one if none is given; yields the connection options of a client."""
    model = World.model_validate(world or SMALL_WORLD)
    loaded: Any = SimpleNamespace(world=model, hash=world_hash(model), warnings=(), path=None)
    with Host(loaded, options, RunSettings(**settings), wires=wires, sinks=sinks) as host:
        host.start()
        yield SessionOptions(connect=host.endpoints)
