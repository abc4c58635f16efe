"""``hmrsim experiment report``: a page, or JSON."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path

import pytest

from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.store import Results, Row

EXPERIMENT = """\
name: crossing
world: zoo/crossing
treatments: {a: {command: one}, b: {command: two}}
replications: 4
measures: {time: end.at}
"""


@pytest.fixture
def said(tmp_path, monkeypatch, hmrsim):
    monkeypatch.chdir(tmp_path)
    Path("e.yaml").write_text(EXPERIMENT, encoding="utf-8")
    plan = read_plan("e.yaml")
    with Results.create(Path("my results"), plan) as results:
        runs = [plan.run_of(number) for number in range(8)]
        results.add(plan, [Row(run, "failed", measures={"time": 1.0 + run.number}) for run in runs])
    return partial(hmrsim, "experiment report")


def test_the_page_is_written_to_the_folder(said):
    assert (0, "page: my results/report.html\n", "") == said("my results")

    page = Path("my results/report.html").read_text(encoding="utf-8")
    assert "hmrsim experiment again &#39;my results&#39; 7 --trace run_7.jsonl" in page


def test_the_output_option_names_a_file_or_stdout(said):
    said("my results", "-o", "page.html")
    code, out, _ = said("my results", "-o", "-")

    assert (0, Path("page.html").read_text(encoding="utf-8") + "\n") == (code, out)
    assert not Path("my results/report.html").exists()


def test_json_has_the_content_of_the_page(said):
    code, out, _ = said("my results", "--json")
    found = json.loads(out)

    assert (0, "crossing", 8, 0) == (code, found["experiment"]["name"], found["runs"], found["successes"])
    assert [4.0, 5.0] == [each["measures"]["time"]["mean"]["estimate"] for each in found["treatments"]]
    assert 1.0 == found["comparisons"][0]["measures"]["time"]["difference"]["estimate"]
    assert not Path("my results/report.html").exists()
    assert (0, out) == said("my results", "--json", "-o", "page.html")[:2]
    assert Path("page.html").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("my results", "--json", "-o", "-"), 2, "both write to the standard output"),
        (("nothing",), 2, "nothing: there are no results"),
        (("my results", "-o", "no/page.html"), 2, "-o no/page.html: can't be written: no such file or directory"),
        (("my results", "-o", "/dev/full"), 1, "-o /dev/full: can't be written: no space left on device"),
    ],
)
def test_errors_are_one_line(said, arguments, code, text):
    found, _, error = said(*arguments)

    assert (code, 1) == (found, len(error.splitlines()))
    assert text in error


def test_without_scipy_the_error_names_the_extra(said, monkeypatch):
    for name in ("numpy", "scipy"):
        monkeypatch.setitem(sys.modules, name, None)

    assert (1, "", "hmrsim: the statistics of experiments need scipy; pip install 'hmrsim[experiments]'\n") == said(
        "my results"
    )
