"""Reducing a failure: the smallest schedule in the smallest world that fails for the same reason."""
