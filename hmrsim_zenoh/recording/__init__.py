"""Recordings: MCAP files with ROS 2 messages, and with the data of the page and of reports."""

from hmrsim_zenoh.recording.reader import Recording, open_recording

__all__ = ["Recording", "open_recording"]
