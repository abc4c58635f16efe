"""What a controller knows of the world: the robots and places that the simulator tells it.

Behaviours look names up here.
"""
