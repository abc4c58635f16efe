"""Overlays: changes of a world by path, from a file or from ``--set PATH=VALUE``, laid over it before it is checked."""
