"""The file of an experiment: what is varied, how often it is run, and what is measured."""
