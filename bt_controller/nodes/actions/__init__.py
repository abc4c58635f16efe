"""Nodes that do something: one file a family."""
