"""Judging a run from the truth: how it has ended, and what was measured."""
