"""The parts of the JSON wire that servers and clients share: keys, envelopes, encodings and sessions.

The client, the server, recordings, the doctor and the page use it.
"""
