"""Schedules: what goes wrong in a run, and when."""
