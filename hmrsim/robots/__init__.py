"""Robots: the states of a mobile base, its power, components and docking.

The simulation builds robots of these; actions, traffic, docks and faults know them by protocols.
"""
