"""Experiments: many runs of one mission, and what they allow one to claim."""
