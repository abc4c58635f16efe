"""The history of a run: the time of its events, and the state of robots, items, facilities, orders and faults."""
