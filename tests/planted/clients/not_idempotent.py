"""The steps are done from the first one, whatever was done before the controller was restarted."""

from driving import Driver

from hmrsim_zenoh import Client


def errand(client: Client, *, bug: bool = False) -> bool:
    """Bring the parcel to the ward; return whether that succeeded."""
    wall_e = Driver(client, "wall_e")
    if not bug:
        return wall_e.bring("parcel", "ward")
    steps = (
        lambda: wall_e.go("shelf"),
        lambda: wall_e.pickup("parcel"),  # the bug: it may have the parcel
        lambda: wall_e.go("ward"),
        lambda: wall_e.place("parcel"),
    )
    return all(wall_e.insist(step) for step in steps)
