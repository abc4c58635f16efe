"""YAML and JSON documents: read, validated, and with all errors reported at once, each with its line and a remedy.

Worlds, overlays, tables, settings, experiments, checks and properties are all read here.
"""
