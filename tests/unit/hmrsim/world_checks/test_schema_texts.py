"""The schema of worlds helps in an editor: each key has a text, and nothing speaks of our classes."""

from __future__ import annotations

from hmrsim.world_checks.schema import world_schema


def walk(part, path=()):
    """Yield each part of a schema, with its path."""
    if isinstance(part, dict):
        yield path, part
        for name, each in part.items():
            yield from walk(each, (*path, name))
    elif isinstance(part, list):
        for number, each in enumerate(part):
            yield from walk(each, (*path, str(number)))


def test_every_key_has_a_text():
    """Every key has a description, or refers to a definition with one."""
    schema = world_schema()
    lacking = []
    for path, part in walk(schema):
        for name, each in (part.get("properties") or {}).items():
            if isinstance(each, dict) and not {"description", "$ref"} & each.keys():
                lacking.append("/".join((*path, name)))

    assert [] == lacking


def test_it_has_a_name_and_no_names_of_classes():
    """The schema has no titles except its own, as editors would show them instead of descriptions."""
    schema = world_schema()

    assert "urn:hmrsim:schema:world" == schema["$id"]
    assert ["hmrsim world"] == [part["title"] for _, part in walk(schema) if isinstance(part.get("title"), str)]
