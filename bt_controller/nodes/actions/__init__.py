"""Action nodes: one file for each family."""
