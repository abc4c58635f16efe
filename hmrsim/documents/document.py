"""The reader of YAML and JSON files."""

from __future__ import annotations

import stat
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

from pydantic import BaseModel

from hmrsim.diagnostics import Finding, limited, problems_of, shown
from hmrsim.documents.valid_parts import valid_parts
from hmrsim.documents.yaml_text import Unreadable, as_yaml, line_of, read_yaml
from hmrsim.errors import DocumentError, Problem, WorldError, reason_of

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path as FieldPath

M = TypeVar("M", bound=BaseModel)

MAX_BYTES: Final = 16 * 1024 * 1024
"""Maximum size of a file, in bytes."""


LineOf: TypeAlias = "Callable[[FieldPath], int | None]"
"""A function that returns the line of a field, or of the nearest part that should hold it; None if it is unknown."""


def no_line(_path: FieldPath) -> int | None:
    """Return no line, for values that come from no file."""
    return None


@dataclass(frozen=True)
class Document:
    """The content of a YAML or JSON file, or values from elsewhere that stand for one.

    Attributes:
        file: The file as the user named it, or the place that the values come from.
        data: The content, a mapping unless the reader asked for any value.
        error: The class of the errors that are raised about this document.
        line: Returns the line of a field.
        findings: The errors that were found while reading, such as duplicate keys.
    """

    file: str
    data: Any
    error: type[DocumentError]
    line: LineOf = no_line
    findings: tuple[Finding, ...] = ()

    def problems(self, findings: Iterable[Finding]) -> list[Problem]:
        """Return findings with the file and their lines, in the order of the lines."""
        return problems_of(findings, self.file, self.line)

    def check_mapping(self, expected: str) -> None:
        """Check that the content is the expected mapping, such as "a mapping of names to files".

        Raises:
            DocumentError: The content is anything else; the error is of the document's class.
        """
        if not isinstance(self.data, dict):
            raise self.error([Problem(self.file, "", f"expected {expected}, got {shown(self.data)}", 1)])

    def raise_for(self, findings: Iterable[Finding] = ()) -> None:
        """Raise all findings, after those of reading; do nothing if there are none.

        Raises:
            DocumentError: There are findings; the error is of the document's class.
        """
        problems = self.problems([*self.findings, *findings])
        if problems:
            raise self.error(limited(problems, self.file))

    def validated(self, model: type[M]) -> M:
        """Return the content as a model.

        Raises:
            DocumentError: The content is invalid; the error is of the document's class and has all errors.
        """
        valid = valid_parts(self.data, model)
        self.raise_for(valid.findings)
        if valid.value is None:
            raise AssertionError
        return valid.value


def read_document(path: str | Path, error: type[DocumentError], expected: str = "") -> Document:
    """Read a YAML or JSON file.

    Args:
        path: The file, which errors name as it is given.
        error: The class of errors.
        expected: The mapping that the file should have, such as "a mapping of names to files"; empty for any value.

    Raises:
        DocumentError: The file can't be read, or has no mapping; the error is of the given class.
    """
    return parse_document(read_text(Path(path), str(path), error), str(path), error, expected)


def parse_document(text: str, file: str, error: type[DocumentError], expected: str = "") -> Document:
    """Return the document of a YAML or JSON text; see `read_document`.

    Raises:
        DocumentError: The text is neither, or has no mapping; the error is of the given class.
    """
    try:
        data, lines, findings = read_yaml(as_yaml(text) if text.lstrip().startswith(("{", "[")) else text)
    except Unreadable as flaw:
        raise error([Problem(file, "", str(flaw), flaw.line)]) from None
    document = Document(file, data, error, partial(line_of, lines), tuple(findings))
    if expected:
        document.check_mapping(expected)
    return document


def read_text(path: Path, file: str, error: type[DocumentError] = WorldError) -> str:
    """Return the text of a file; *file* is its name as the user knows it, for errors.

    Raises:
        DocumentError: The file can't be read, is too large, or is not text; the error is of the given class.
    """
    line = None
    try:
        # Reading a named pipe or device might never end.
        if stat.S_ISREG(path.stat().st_mode):
            with path.open("rb") as stream:
                content = stream.read(MAX_BYTES + 1)
            if len(content) <= MAX_BYTES:
                return content.decode("utf-8-sig")
            why = f"is larger than {MAX_BYTES // 1024 // 1024} MiB"
        else:
            why = f"is {'a folder' if path.is_dir() else 'not a regular file'}; expected a file"
    except FileNotFoundError:
        why = "no such file"
    except OSError as flaw:
        why = f"can't be read: {reason_of(flaw)}"
    except UnicodeDecodeError as flaw:
        line = flaw.object.count(b"\n", 0, flaw.start) + 1
        why = f"is not UTF-8: byte 0x{flaw.object[flaw.start]:02x}; save it as UTF-8"
    except ValueError:
        why = "can't be read: its name has a null character"
    raise error([Problem(file, "", why, line)])
