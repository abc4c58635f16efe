"""What is kept of files while they stay the same."""

from __future__ import annotations

import os

import pytest

from hmrsim import file_cache
from hmrsim.file_cache import FileCache


class Reader:
    """Reads a file, and counts how often it does."""

    def __init__(self, path):
        self.path = path
        self.count = 0

    def __call__(self):
        """Return the text of the file."""
        self.count += 1
        return self.path.read_text()


@pytest.fixture
def reader(tmp_path):
    """Return what reads a file."""
    path = tmp_path / "a"
    path.write_text("one")
    return Reader(path)


def asked(cache, reader, key="key"):
    """Return the value of a key."""
    return cache.get(key, reader, lambda _text: [reader.path])


def test_a_file_is_read_once_while_it_stays_the_same(reader):
    """A change is noticed by the content: times of files are too coarse."""
    cache = FileCache()
    before = reader.path.stat()
    texts = [asked(cache, reader), asked(cache, reader)]
    reader.path.write_text("two")
    os.utime(reader.path, ns=(before.st_atime_ns, before.st_mtime_ns))
    texts += [asked(cache, reader), asked(cache, reader)]

    assert (["one", "one", "two", "two"], 2) == (texts, reader.count)


def test_a_file_that_is_gone_is_read_again(reader):
    """So that its absence is the error that it is."""
    cache = FileCache()
    asked(cache, reader)
    reader.path.unlink()
    with pytest.raises(FileNotFoundError):
        asked(cache, reader)
    reader.path.write_text("one")

    assert ("one", 2) == (asked(cache, reader), reader.count)


@pytest.mark.parametrize("replace", [os.mkfifo, os.mkdir])
def test_what_takes_the_place_of_a_file_is_not_waited_for(reader, replace):
    """The reader is asked, whose error it is."""
    cache = FileCache()
    asked(cache, reader)
    reader.path.unlink()
    replace(reader.path)

    assert "read" == cache.get("key", lambda: "read", lambda _text: [])


def test_the_value_that_was_not_asked_for_the_longest_is_forgotten(reader):
    """There are so many and no more."""
    cache = FileCache(2)
    for key in "abac":
        asked(cache, reader, key)
    known = [asked(cache, reader, key) for key in "ac"]

    assert (["one", "one"], 3) == (known, reader.count)
    asked(cache, reader, "b")
    assert 4 == reader.count


def test_large_files_are_read_each_time(reader, monkeypatch):
    """They would fill the memory."""
    monkeypatch.setattr(file_cache, "MAX_BYTES", 2)
    cache = FileCache()
    for _ in range(2):
        asked(cache, reader)

    assert 2 == reader.count
