"""Nodes that look at something: one file a family."""
