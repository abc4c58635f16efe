"""Runs of schedules: one run in a worker, and many runs on an executor."""
