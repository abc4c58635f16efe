"""Served worlds: a simulator, its servers and what runs them, over Zenoh or within one process."""
