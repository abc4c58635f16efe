"""The seam between the simulation and everything outside: commands, answers, goals and who takes part in time.

Servers, clients and controllers speak it with the simulator; it knows neither simpy nor a network.
"""
