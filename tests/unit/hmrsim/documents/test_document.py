"""The reader of YAML and JSON files."""

from __future__ import annotations

import pytest
from pydantic import BaseModel

from hmrsim.diagnostics import MAX_FINDINGS, Finding
from hmrsim.documents.document import Document, parse_document, read_document
from hmrsim.errors import CheckError, ExperimentError, SettingsError


class Named(BaseModel, extra="forbid"):
    name: str


def test_all_errors_are_reported_with_their_lines():
    document = parse_document("name: 1\nname: 2\nnam: x\n", "a.yaml", CheckError, "a mapping")

    with pytest.raises(CheckError) as caught:
        document.validated(Named)

    assert [
        "a.yaml:1: name: expected text, got 1; put it in quotes",
        "a.yaml:2: name: key 'name' is there twice, first in line 1; keep one",
        "a.yaml:3: nam: unknown key 'nam'; did you mean 'name'?",
    ] == [str(problem) for problem in caught.value.problems]


@pytest.mark.parametrize("text", ["name: eve", '{"name":\t"eve"}'])
def test_a_document_is_yaml_or_json(text):
    """JSON may have tabs between its values."""
    assert Named(name="eve") == parse_document(text, "a.yaml", CheckError).validated(Named)


def test_errors_have_the_requested_class(tmp_path):
    (tmp_path / "list.yaml").write_text("[1]")

    with pytest.raises(SettingsError, match="no such file"):
        read_document(tmp_path / "none.yaml", SettingsError)
    with pytest.raises(ExperimentError, match=r"list\.yaml:1: expected a mapping of names, got \[1\]"):
        read_document(tmp_path / "list.yaml", ExperimentError, "a mapping of names")


def test_errors_are_bounded():
    with pytest.raises(CheckError) as caught:
        Document("a", {}, CheckError).raise_for(Finding(("x", i), "is wrong") for i in range(MAX_FINDINGS + 5))

    assert MAX_FINDINGS + 1 == len(caught.value.problems)
    assert "a: and 5 more" == str(caught.value.problems[-1])
