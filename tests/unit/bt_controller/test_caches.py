"""The classes of trees that the package caches."""

from __future__ import annotations

import importlib
import pkgutil

import bt_controller


def test_caches_by_class_are_limited():
    """A tree may define its classes in each run, with whatever their methods refer to."""
    names = [module.name for module in pkgutil.walk_packages(bt_controller.__path__, "bt_controller.")]
    caches = {
        f"{name}.{function}": value.cache_parameters()["maxsize"]
        for name in names
        if not name.endswith("__main__")
        for function, value in vars(importlib.import_module(name)).items()
        if hasattr(value, "cache_parameters") and "type[Behaviour]" in value.__wrapped__.__annotations__.values()
    }

    assert "bt_controller.running.schedule._kind" in caches
    assert [] == [name for name, limit in caches.items() if limit is None]
