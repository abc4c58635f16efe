"""Trials: a controller that controls the robots of a world, from the start of the run to its end.

Experiments, fault search, unit tests and environments for learning stand on this.
"""
