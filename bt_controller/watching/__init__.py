"""Showing what trees do: on a terminal, as JSON, on Zenoh, as pictures, as a log. The commands use it."""
