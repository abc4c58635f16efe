"""The client of a simulator: actions, topics, services and participation in lockstep.

Controllers, scripts and the command line tools use it; `hmrsim_zenoh` exports its names.
"""
