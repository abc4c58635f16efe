"""The properties that are built in."""
