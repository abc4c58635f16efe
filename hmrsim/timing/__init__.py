"""Pacing of simulated time: by the wall clock, or in lockstep with the controllers that take part.

Hosts run a simulator through it; it also keeps results for as long as clients may ask for them.
"""
