"""What both ends of the JSON wire share: keys, envelopes, encodings and sessions.

The client, the server, recordings, the doctor and the page use it.
"""
