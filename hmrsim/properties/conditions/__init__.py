"""Conditions of a file as functions of the state of the world, and in words."""
