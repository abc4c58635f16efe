"""The robot counts as arrived when little distance remains, but a goal that fails has no further feedback."""

from driving import Driver, succeeds

from hmrsim_zenoh import Client


def rounds(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")

    def visit(place: str) -> bool:
        handle = wall_e.start_to(place, on_feedback=lambda _feedback: None)
        while bug and (handle.feedback is None or handle.feedback.distance_remaining > 0.2):  # the bug: not its result
            client.sleep(1.0)
        return succeeds(handle)

    return all(wall_e.insist(lambda place=place: visit(place)) for place in ("ward_a", "ward_b"))
