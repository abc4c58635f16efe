"""The texts of the world's schema, which editors show."""

from __future__ import annotations

from hmrsim.world_checks.schema import world_schema


def walk(part, path=()):
    if isinstance(part, dict):
        yield path, part
        for name, each in part.items():
            yield from walk(each, (*path, name))
    elif isinstance(part, list):
        for number, each in enumerate(part):
            yield from walk(each, (*path, str(number)))


def test_every_key_has_a_description():
    schema = world_schema()
    lacking = []
    for path, part in walk(schema):
        for name, each in (part.get("properties") or {}).items():
            if isinstance(each, dict) and not {"description", "$ref"} & each.keys():
                lacking.append("/".join((*path, name)))

    assert [] == lacking


def test_no_title_names_a_class():
    schema = world_schema()

    assert "urn:hmrsim:schema:world" == schema["$id"]
    assert ["hmrsim world"] == [part["title"] for _, part in walk(schema) if isinstance(part.get("title"), str)]
