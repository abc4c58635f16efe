"""After a restart the controller repeats all steps from the first one, whether they were done or not."""

from driving import Driver

from hmrsim_zenoh import Client


def errand(client: Client, *, bug: bool = False) -> bool:
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
