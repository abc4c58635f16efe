"""Damaged input for everything that reads some; `python -m tests.torture.files --help`."""
