"""Showing what trees are at: on a terminal, as JSON, on Zenoh, as pictures, as a log."""
