"""A loop waits for a terminal status, which a rejected goal never has."""

from driving import Driver, succeeds

from hmrsim_zenoh import Client


def rounds(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")

    def visit(place: str) -> bool:
        handle = wall_e.start_to(place)
        while bug and not handle.status.terminal:  # the bug: `done` would be true, and `error` say why
            client.sleep(1.0)
        return succeeds(handle)

    return all(wall_e.insist(lambda place=place: visit(place)) for place in ("ward_a", "ward_b"))
