"""A running world: entities, scripts, faults and detections, put together by the simulator.

Programs and servers make a `Simulator`, submit commands to it and receive its events.
"""
