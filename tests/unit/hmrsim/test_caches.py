"""The cache of values that are read from files."""

from __future__ import annotations

import os

import pytest

from hmrsim import caches
from hmrsim.caches import FileCache


class Reader:
    def __init__(self, path):
        self.path = path
        self.count = 0

    def __call__(self):
        self.count += 1
        return self.path.read_text()


@pytest.fixture
def reader(tmp_path):
    path = tmp_path / "a"
    path.write_text("one")
    return Reader(path)


def asked(cache, reader, key="key"):
    return cache.get(key, reader, lambda _text: [reader.path])


def test_an_unchanged_file_is_read_once(reader):
    """A change is detected by the content, because times of files are too coarse."""
    cache = FileCache()
    before = reader.path.stat()
    texts = [asked(cache, reader), asked(cache, reader)]
    reader.path.write_text("two")
    os.utime(reader.path, ns=(before.st_atime_ns, before.st_mtime_ns))
    texts += [asked(cache, reader), asked(cache, reader)]

    assert (["one", "one", "two", "two"], 2) == (texts, reader.count)


def test_a_deleted_file_is_read_again(reader):
    cache = FileCache()
    asked(cache, reader)
    reader.path.unlink()
    with pytest.raises(FileNotFoundError):
        asked(cache, reader)
    reader.path.write_text("one")

    assert ("one", 2) == (asked(cache, reader), reader.count)


@pytest.mark.parametrize("replace", [os.mkfifo, os.mkdir])
def test_a_pipe_in_place_of_the_file_does_not_block(reader, replace):
    cache = FileCache()
    asked(cache, reader)
    reader.path.unlink()
    replace(reader.path)

    assert "read" == cache.get("key", lambda: "read", lambda _text: [])


def test_the_least_recently_used_value_is_dropped(reader):
    cache = FileCache(2)
    for key in "abac":
        asked(cache, reader, key)
    known = [asked(cache, reader, key) for key in "ac"]

    assert (["one", "one"], 3) == (known, reader.count)
    asked(cache, reader, "b")
    assert 4 == reader.count


def test_large_files_are_not_cached(reader, monkeypatch):
    monkeypatch.setattr(caches, "MAX_BYTES", 2)
    cache = FileCache()
    for _ in range(2):
        asked(cache, reader)

    assert 2 == reader.count
