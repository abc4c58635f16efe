"""The ROS 2 wires that the settings of ``hmrsim run`` enable."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.settings import ROS_DOMAIN_ID, domain_id

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.settings import Ros2Settings


def ros2_wires(settings: Ros2Settings) -> tuple[Wire, ...]:
    """Return the wires that the settings ask for.

    Raises:
        BadOptions: Options don't go together, or the environment's domain is invalid.
    """
    # Environment variables apply to all runs, so they are not an error for runs without ROS.
    if settings.ros_domain_id is not None and not settings.ros2 and not os.environ.get("HMRSIM_ROS_DOMAIN_ID"):
        raise BadOptions("--ros-domain-id is for --ros2; add that")
    if settings.ros_distro and not (settings.ros2 or settings.ros2dds or os.environ.get("HMRSIM_ROS_DISTRO")):
        raise BadOptions("--ros-distro is for --ros2 and --ros2dds; add one of them")
    if not (settings.ros2 or settings.ros2dds):
        return ()
    # Loads the codecs, which takes 40 ms and is needed for runs with ROS only.
    from hmrsim_zenoh.ros2 import wires

    distros = tuple(dict.fromkeys(settings.ros_distro))
    opened: list[Wire] = []
    if settings.ros2:
        domain = _domain() if settings.ros_domain_id is None else settings.ros_domain_id
        opened.append(wires.RmwZenoh(domain, distros) if distros else wires.RmwZenoh(domain))
    if settings.ros2dds:
        opened.append(wires.Ros2Dds(distros[0]) if distros else wires.Ros2Dds())
    return tuple(opened)


def _domain() -> int:
    """Return the domain of ROS nodes in this shell."""
    try:
        return domain_id(os.environ.get(ROS_DOMAIN_ID) or "0")
    except ValueError as error:
        raise BadOptions(f"{ROS_DOMAIN_ID}: {error}; correct it, or give --ros-domain-id") from None
