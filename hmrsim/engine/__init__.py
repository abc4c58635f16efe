"""The discrete-event engine: simpy's environment, extended, subscriptions, sampling and the only wall clock.

All events in simulated time are scheduled here; the simulation, robots and goals use it.
"""
