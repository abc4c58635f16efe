"""What happens in a run, as properties see it: an order of time, and the state of the world."""
