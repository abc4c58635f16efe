"""What robots are made of: the states of a mobile base, and what it asks of docks.

The simulation builds robots of these; actions, traffic, docks and faults know them by protocols.
"""
