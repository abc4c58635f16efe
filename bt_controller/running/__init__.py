"""Running trees: when they are ticked, how time goes by, how a run ends."""
