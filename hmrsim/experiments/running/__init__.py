"""Executing runs: one in a worker, many on an executor."""
