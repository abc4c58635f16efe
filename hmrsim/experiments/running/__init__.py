"""Runs of an experiment: one run in a worker, and all runs on an executor."""
