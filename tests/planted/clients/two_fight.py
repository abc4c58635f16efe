"""A controller resends its goal when another controller preempts it, and so preempts that one's goal."""

from driving import Driver, Handle, item_of, succeeds

from hmrsim_zenoh import Client


class _Preempted(Exception):
    """Another controller drives the robot."""


def errand(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")

    def ends_well(handle: Handle) -> bool:
        while not succeeds(handle):
            if handle.cause != "preempted":
                return False
            if not bug:
                raise _Preempted
            handle = wall_e.start_to("ward" if _has(client) else "shelf")  # the bug: it insists
        return True

    def bring() -> bool:
        found = item_of(client, "parcel")
        if wall_e.near(found, "ward"):
            return True
        x, y = found["at"]
        have = _has(client) or (ends_well(wall_e.start_to((x, y))) and ends_well(wall_e.start_pickup("parcel")))
        return have and ends_well(wall_e.start_to("ward")) and ends_well(wall_e.start_place("parcel"))

    try:
        return wall_e.insist(bring)
    except _Preempted:
        # The other one does it.
        return wall_e.insist(lambda: wall_e.near(item_of(client, "parcel"), "ward"))


def _has(client: Client) -> bool:
    return item_of(client, "parcel")["carrier"] == "wall_e"
