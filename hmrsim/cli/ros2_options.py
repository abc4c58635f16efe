"""The options of ``hmrsim run`` that say which wires of ROS 2 are spoken."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.ros2.codec.distros import DISTROS
from hmrsim_zenoh.ros2.keys import DOMAINS, MAX_DOMAIN

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.wires import Wire

VARIABLE: Final = "ROS_DOMAIN_ID"
"""ROS's own, which says the domain to all its nodes."""


def add_ros2_options(parser: argparse.ArgumentParser) -> None:
    """Add them."""
    group = parser.add_argument_group("ROS 2")
    group.add_argument(
        "--ros2",
        action="store_true",
        help="let ROS 2 nodes with RMW_IMPLEMENTATION=rmw_zenoh_cpp drive the robots: `ros2 action send_goal`, rclpy, "
        "Nav2's clients; no ROS is needed here",
    )
    group.add_argument(
        "--ros-domain-id",
        type=domain_id,
        metavar="N",
        help=f"with --ros2, ROS's domain (default: the environment's {VARIABLE}, else 0)",
    )
    group.add_argument(
        "--ros-distro",
        action="append",
        choices=DISTROS,
        help="speak its types alone, whose hashes differ from others'; repeatable (default: with --ros2 those of all: "
        f"{', '.join(DISTROS)})",
    )
    group.add_argument(
        "--ros2dds",
        action="store_true",
        help="speak as zenoh-bridge-ros2dds does, as Open-RMF's free_fleet expects; the types are those of the first "
        f"--ros-distro (default: {DISTROS[0]})",
    )


def ros2_wires(args: argparse.Namespace) -> tuple[Wire, ...]:
    """Return the wires that a command line asks for.

    Raises:
        BadOptions: Options don't go together, or the environment's domain is none.
    """
    # Variables say what holds for all runs, so that those without ROS are no mistake.
    if args.ros_domain_id is not None and not args.ros2 and not os.environ.get("HMRSIM_ROS_DOMAIN_ID"):
        raise BadOptions("--ros-domain-id is for --ros2; add that")
    if args.ros_distro and not (args.ros2 or args.ros2dds or os.environ.get("HMRSIM_ROS_DISTRO")):
        raise BadOptions("--ros-distro is for --ros2 and --ros2dds; add one of them")
    if not (args.ros2 or args.ros2dds):
        return ()
    # Loads the codecs, which take 40 ms and serve runs with ROS alone.
    from hmrsim_zenoh.ros2 import wires as of  # noqa: PLC0415

    distros = tuple(dict.fromkeys(args.ros_distro or ()))
    wires: list[Wire] = []
    if args.ros2:
        domain = _domain() if args.ros_domain_id is None else args.ros_domain_id
        wires.append(of.RmwZenoh(domain, distros) if distros else of.RmwZenoh(domain))
    if args.ros2dds:
        wires.append(of.Ros2Dds(distros[0]) if distros else of.Ros2Dds())
    return tuple(wires)


def domain_id(text: str) -> int:
    """Return one of ROS's domains."""
    if text not in DOMAINS:
        raise argparse.ArgumentTypeError(f"{text[:20]!r} is no domain; a whole number from 0 to {MAX_DOMAIN} is")
    return DOMAINS[text]


def _domain() -> int:
    """Return the domain that ROS's nodes in this shell have."""
    try:
        return domain_id(os.environ.get(VARIABLE) or "0")
    except argparse.ArgumentTypeError as error:
        raise BadOptions(f"{VARIABLE}: {error}; correct it, or give --ros-domain-id") from None
