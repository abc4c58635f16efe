"""Running trees: the schedule of ticks, the clock, and the end of a run."""
