"""The settings of a run, each declared once.

A model (such as `run.RunSettings`) declares its fields with an `option.Option`. Command-line options, environment
variables, settings files, their JSON Schema and the tables in the docs derive from it. Commands use these models; a
program that runs a world by itself needs `RunSettings` only.
"""
