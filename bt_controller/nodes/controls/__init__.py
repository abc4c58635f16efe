"""Nodes with several children: one file a family."""
