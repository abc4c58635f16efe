"""Nodes with several children: one file for each family."""
