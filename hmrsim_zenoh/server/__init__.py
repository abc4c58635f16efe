"""The simulator's side of the JSON wire: queries become commands, and events become replies and publications.

`hmrsim_zenoh.host` puts it together with a simulator.
"""
