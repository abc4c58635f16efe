"""Display of running trees: on a terminal, as JSON, on Zenoh, as pictures and as a log."""
