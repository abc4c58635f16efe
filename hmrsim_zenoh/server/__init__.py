"""The server of the JSON wire: queries become commands, and events become replies and publications.

`hmrsim_zenoh.hosting` composes it with a simulator.
"""
