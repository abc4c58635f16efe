"""The command-line foundation of `hmrsim` and `bt-controller`: parsers, environment variables, logs and signals."""
