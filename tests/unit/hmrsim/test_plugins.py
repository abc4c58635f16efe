"""Discovery of plug-ins in folders and entry points."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from importlib.metadata import EntryPoint, EntryPoints
from importlib.util import find_spec

import pytest

from hmrsim import plugins
from hmrsim.errors import PluginError
from hmrsim.plugins import GROUPS, discover
from tests.paths import ROOT


@dataclass(frozen=True)
class Thing:
    name: str


@pytest.fixture
def kind(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(package, entries=(), **modules):
        folder = tmp_path / package
        folder.mkdir()
        (folder / "__init__.py").write_text("")
        for name, text in modules.items():
            (folder / f"{name}.py").write_text(f"from test_plugins_kind import Thing\n{text}\n")
        found = EntryPoints(EntryPoint(name, value, package) for name, value in entries)
        monkeypatch.setattr(plugins, "_installed", lambda: found)
        return discover(__import__(package), "THING", Thing)

    monkeypatch.setitem(sys.modules, "test_plugins_kind", sys.modules[__name__])
    return make


def test_a_file_is_a_plugin(kind):
    """Modules with a leading underscore are skipped."""
    assert ["a", "b"] == list(kind("things1", b='THING = Thing("b")', a='THING = Thing("a")', _private="x = 1"))


def test_a_file_can_hold_a_family_of_plugins(kind):
    assert ["a", "b", "c"] == list(kind("family1", letters='THINGS = (Thing("c"), Thing("a"))', b='THING = Thing("b")'))


def test_an_entry_point_is_a_plugin(kind, tmp_path):
    (tmp_path / "elsewhere.py").write_text('from test_plugins_kind import Thing\nTHING = Thing("elsewhere")\n')

    assert ["a", "elsewhere"] == list(kind("things2", [("elsewhere", "elsewhere")], a='THING = Thing("a")'))


@pytest.mark.parametrize(
    ("package", "text", "message"),
    [
        ("things3", "x = 1", r"a\.py: THING must be one Thing, found None"),
        ("things4", 'THING = Thing("b")', r"a\.py: THING is named 'b'; name it as its file"),
        ("things5", "import no_such_module", r"things5\.a: can't be imported: No module named 'no_such_module'"),
    ],
)
def test_a_broken_plugin_is_an_error_that_names_the_file(kind, package, text, message):
    with pytest.raises(PluginError, match=message):
        kind(package, a=text)


@pytest.mark.parametrize(
    ("package", "text", "message"),
    [
        ("others1", 'THING = Thing("a")', "others1_more.a: there is a plug-in named 'a' already"),
        ("others2", "1 / 0", "others2_more.a: can't be imported: division by zero"),
        ("others5", "raise ValueError('\\x1b[2J')", r"others5_more.a: can't be imported: \x1b[2J"),
        ("others3", "exit()", "others3_more.a: can't be imported: it ends the program"),
        ("others4", "x = 1", "a.py: THING must be one Thing, found None"),
    ],
)
def test_a_broken_plugin_of_another_package_is_left_out(kind, tmp_path, monkeypatch, caplog, package, text, message):
    monkeypatch.setattr(plugins, "_left_out", [])
    folder = tmp_path / f"{package}_more"
    folder.mkdir()
    (folder / "a.py").write_text(f"from test_plugins_kind import Thing\n{text}\n")
    plugins.check()

    assert ["a"] == list(kind(package, [("a", f"{package}_more.a")], a='THING = Thing("a")'))
    assert f"{message}; it is left out" in caplog.text
    with pytest.raises(PluginError, match=re.escape(message)):
        plugins.check()


@pytest.mark.parametrize(
    ("group", "warning"),
    [
        ("hmrsim.action", "there is no group of entry points 'hmrsim.action'; did you mean 'hmrsim.actions'?"),
        ("hmrsim_zenoh.things", None),
        ("pytest11", None),
        ("hmrsim.actions", None),
    ],
)
def test_an_unknown_entry_point_group_is_reported(monkeypatch, caplog, group, warning):
    """The group may be a typing error in a project file; groups of other packages are ignored."""
    found = EntryPoints([EntryPoint("wipe", "my_robots.wipe", group)])
    monkeypatch.setattr(plugins, "entry_points", lambda: found)
    plugins._installed.__wrapped__()

    assert [f"{warning}; my_robots.wipe is left out"] * (warning is not None) == caplog.messages


def test_the_groups_are_the_plugin_packages():
    kinds = {path.parent for path in (ROOT / "hmrsim").rglob("*.py") if "discover(sys.modules[" in path.read_text()}

    assert {".".join(kind.relative_to(ROOT).parts) for kind in kinds} == {
        group for group in GROUPS if group.startswith("hmrsim.")
    }
    assert all(find_spec(group) for group in GROUPS)
