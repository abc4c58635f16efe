"""Overlays: changes of a world by path, from a file or from ``--set PATH=VALUE``, applied before it is checked."""
