"""A simulator and its clients in one process: the same keys, requests and answers as over Zenoh, without a network."""
