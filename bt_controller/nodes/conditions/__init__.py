"""Conditions: one file for each family."""
