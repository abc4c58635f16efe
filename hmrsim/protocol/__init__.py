"""The interface between the simulation and its clients: commands, answers, goals and participants in lockstep.

Servers, clients and controllers speak it with the simulator; it knows neither simpy nor a network.
"""
