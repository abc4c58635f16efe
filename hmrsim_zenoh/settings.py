"""All settings of a served simulation: of the run, the session, the recording, the page and the ROS 2 wires."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from hmrsim.program.log_options import ServerLogOptions
from hmrsim.settings.option import Option
from hmrsim.settings.run import RunSettings, Settings, TraceSettings, WorldSettings, together
from hmrsim_zenoh.ros2.keys import DOMAINS, MAX_DOMAIN
from hmrsim_zenoh.view import DEFAULT_PORT
from hmrsim_zenoh.wire.options import SessionOptions

ROS_DOMAIN_ID: Final = "ROS_DOMAIN_ID"
"""ROS's own variable, which sets the domain of all its nodes."""

_MAX_PORT: Final = 65_535


def port(text: str) -> int:
    """Return a port, or 0."""
    if not text.isdecimal() or int(text) > _MAX_PORT:
        raise ValueError(f"{text!r} is not a port; expected a whole number from 0 to {_MAX_PORT}")
    return int(text)


def domain_id(text: str) -> int:
    """Return one of ROS's domains."""
    if text not in DOMAINS:
        raise ValueError(f"{text[:20]!r} is not a domain id; expected a whole number from 0 to {MAX_DOMAIN}")
    return DOMAINS[text]


class RecordSettings(Settings):
    """The settings of a run's recording."""

    record: Annotated[
        Path | None,
        Option("record all published messages to an MCAP file, for Foxglove and `hmrsim view`", "FILE.mcap"),
    ] = None


class MonitorSettings(Settings):
    """The settings of the monitor that checks properties during a run."""

    monitor: Annotated[
        Path | None,
        Option(
            "monitor the properties in a file: violations are logged, recorded and shown on the page, and the exit "
            "code is 1",
            "FILE",
        ),
    ] = None


class ViewSettings(Settings):
    """The settings of a run's live page."""

    view: Annotated[
        int | None,
        Option(
            f"also serve the live view to a browser on this machine (default port: {DEFAULT_PORT}; 0: a free "
            "one); `hmrsim view` does it elsewhere",
            "PORT",
            at_least=0,
            at_most=_MAX_PORT,
            bare=DEFAULT_PORT,
            read=port,
        ),
    ] = None


class Ros2Settings(Settings):
    """The ROS 2 wires to serve."""

    ros2: Annotated[
        bool,
        Option(
            "let ROS 2 nodes with RMW_IMPLEMENTATION=rmw_zenoh_cpp drive the robots: `ros2 action send_goal`, rclpy, "
            "Nav2's clients; no ROS is needed here",
            group="ROS 2",
        ),
    ] = False
    ros_domain_id: Annotated[
        int | None,
        Option(
            "with --ros2, ROS's domain",
            "N",
            group="ROS 2",
            default_text=f"the environment's {ROS_DOMAIN_ID}, else 0",
            at_least=0,
            at_most=MAX_DOMAIN,
            read=domain_id,
        ),
    ] = None
    ros_distro: Annotated[
        tuple[Literal["jazzy", "kilted", "lyrical", "rolling"], ...],
        Option(
            "use only the types of this distribution, because type hashes differ between distributions; repeatable",
            group="ROS 2",
            default_text="with --ros2 those of all: jazzy, kilted, lyrical, rolling",
        ),
    ] = ()
    ros2dds: Annotated[
        bool,
        Option(
            "use the keys of zenoh-bridge-ros2dds, as Open-RMF's free_fleet expects; message types are those of the "
            "first --ros-distro",
            group="ROS 2",
            default_text="jazzy",
        ),
    ] = False


SERVED: Final = (
    WorldSettings,
    TraceSettings,
    RecordSettings,
    MonitorSettings,
    RunSettings,
    ViewSettings,
    Ros2Settings,
    SessionOptions,
    ServerLogOptions,
)
"""All that ``hmrsim run`` can be told, in the order of its ``--help``."""


def settings_schema() -> dict[str, Any]:
    """Return the JSON Schema of settings files."""
    schema = together(SERVED).model_json_schema()
    for part in schema["properties"].values():
        part.pop("title", None)
        if part.get("default") == math.inf:
            del part["default"]
    return {**schema, "title": "hmrsim settings"}
