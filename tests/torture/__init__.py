"""Damaged input for every reader; see `python -m tests.torture.files --help`."""
