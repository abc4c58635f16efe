"""Nodes with one child: one file for each family."""
