"""The settings of a run, each declared once.

A model here (`run.RunSettings` and its like) declares its fields with an `option.Option`; command-line options,
environment variables, settings files, their JSON Schema and the tables in the docs derive from it. The commands use
these models, and so does a program that runs a world itself, which needs `RunSettings` only.
"""
