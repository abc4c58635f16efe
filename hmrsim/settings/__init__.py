"""The settings of a run, each declared once.

A model here (`run.RunSettings` and its like) declares its fields with an `option.Option`; command-line options,
environment variables, settings files, their JSON Schema and the tables of the docs all come of that. The commands use
it, and so does a program that runs a world by itself, for which `RunSettings` is all that it needs.
"""
