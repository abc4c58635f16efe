"""Nodes with one child: one file a family."""
