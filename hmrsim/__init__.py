"""A mission-level simulator of robots: commands go in, events come out, no I/O."""

__version__ = "0.1.0"

CONTRACT = 1
"""Version of the public interface: keys, messages, traces."""
