"""The client of a simulator: actions, topics, services and its part in lockstep.

Controllers, scripts and the command line tools use it; its names are exported by `hmrsim_zenoh`.
"""
