"""Recordings: MCAP files with the messages of ROS 2, and with all that the page and the report need."""

from hmrsim_zenoh.recording.reading import Recording, open_recording

__all__ = ["Recording", "open_recording"]
