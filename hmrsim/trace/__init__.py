"""Runs as lines of JSON: writing a trace, and running it again.

The commands `run`, `simulate`, `demo` and `replay` use it.
"""
