"""Robots: the vehicle that drives, what it carries, and its power.

Actions give robots their verbs; traffic, facilities and faults know them by protocols.
"""
