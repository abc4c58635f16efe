"""The parcel's position is read once, so a parcel dropped later is looked for in the wrong place."""

from driving import Driver, item_of

from hmrsim_zenoh import Client


def errand(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    before = item_of(client, "parcel")

    def bring() -> bool:
        found = item_of(client, "parcel")
        if wall_e.near(found, "ward"):
            return True
        x, y = (before if bug else found)["at"]  # the bug: it may be somewhere else by now
        have = found["carrier"] == wall_e.robot or (wall_e.go((x, y)) and wall_e.pickup("parcel"))
        return have and wall_e.go("ward") and wall_e.place("parcel")

    return wall_e.insist(bring)
