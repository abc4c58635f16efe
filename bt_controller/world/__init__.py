"""A controller's model of the world: the robots and places that the simulator reports.

Behaviors look names up here.
"""
