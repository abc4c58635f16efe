"""A controller's model of the world: the robots and places that the simulator reports.

Behaviours look names up here.
"""
