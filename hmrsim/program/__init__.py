"""What the programs `hmrsim` and `bt-controller` share: parsers, environment variables, logs and signals.

It knows nothing of simulations; each command line is built on it.
"""
