"""Measurements: ratios within one run, side by side; run as ``python -m benchmarks``."""
