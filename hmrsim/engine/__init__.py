"""The discrete-event engine: simpy's clock with what it lacks, subscriptions, sampling and the only wall clock.

All that happens in simulated time is scheduled here; the simulation, robots and goals use it.
"""
