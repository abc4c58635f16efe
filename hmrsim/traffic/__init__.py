"""Traffic: admission to lanes and waypoints, closures, obstructions, wait timeouts and policies.

Vehicles ask it before each leg; facilities and faults close and open lanes through it.
"""
