"""The controller remembers its finished steps over a reset of the simulation, and does not repeat them."""

from driving import Driver, item_of

from hmrsim_zenoh import Client


def errand(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    if not bug:
        return wall_e.insist(lambda: wall_e.bring("parcel", "ward") and _stays(client, wall_e))
    done = {"picked up"} if item_of(client, "parcel")["carrier"] == wall_e.robot else set()

    def once(name: str, *, succeeded: bool) -> bool:
        done.update([name] if succeeded else [])
        return succeeded

    def bring() -> bool:
        x, y = item_of(client, "parcel")["at"]
        fetched = "picked up" in done or (wall_e.go((x, y)) and once("picked up", succeeded=wall_e.pickup("parcel")))
        # The bug: after a reset the parcel is on the shelf again.
        return fetched and wall_e.go("ward") and wall_e.place("parcel")

    return wall_e.insist(bring)


def _stays(client: Client, wall_e: Driver) -> bool:
    """Return whether the parcel is still in the ward after a moment, and not on its shelf again."""
    client.sleep(1.0)
    return wall_e.near(item_of(client, "parcel"), "ward")
