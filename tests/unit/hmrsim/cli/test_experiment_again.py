"""``hmrsim experiment again``: a run as a page."""

from __future__ import annotations

import pytest
import yaml

from hmrsim.cli import main
from tests.porters import HERE, WORLD

SERIAL = ("--executor", "hmrsim.trials.batches:Serial")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Return the folder of an experiment in which one of three controllers does not succeed."""
    home = tmp_path_factory.mktemp("again")
    (home / "world.yaml").write_text(yaml.safe_dump(WORLD), encoding="utf-8")
    (home / "porters.py").write_text((HERE / "porters.py").read_text("utf-8"), encoding="utf-8")
    treatments = {name: {"python": f"porters.py:{name}"} for name in ("hasty", "broken", "careful")}
    experiment = {"name": "porters", "world": "world.yaml", "treatments": treatments, "replications": 1}
    experiment["overlay"] = {"faults": [{"type": "goals_aborted", "robot": "other", "at": 0.0, "count": 1}]}
    (home / "porters.yaml").write_text(yaml.safe_dump(experiment, sort_keys=False), encoding="utf-8")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(home)
        assert main(["experiment", "run", "porters.yaml", "-o", "results", *SERIAL]) == 0
    return home


@pytest.fixture(autouse=True)
def in_home(home, monkeypatch):
    monkeypatch.chdir(home)


def again(*words):
    return main(["experiment", "again", "results", *words])


def test_a_run_is_shown_beside_that_of_a_treatment_that_succeeds(home, capsys):
    assert again("0", "--page", "run.html") == 0
    page = (home / "run.html").read_text("utf-8")

    assert "page: run.html\n" in capsys.readouterr().err
    assert "<title>hasty: failed" in page
    assert '</i>careful <small title="ends as succeeded at ' in page
    assert "Only the treatment differs." in page


def test_the_other_treatment_can_be_chosen(home):
    assert again("0", "--page", "run.html", "--beside", "broken") == 0

    assert '</i>broken <small title="ends as crashed at 0.0 s' in (home / "run.html").read_text("utf-8")


def test_a_treatment_to_show_beside_it_must_exist_and_need_a_page(capsys):
    for words, error in (
        (("--page", "run.html", "--beside", "quick"), "no other treatment of that name; there are: broken, careful"),
        (("--page", "run.html", "--beside", "hasty"), "no other treatment of that name; there are: broken, careful"),
        (("--beside", "careful"), "--beside careful: it is for --page alone"),
        (("--page", "none/run.html"), "--page none/run.html: can't be written"),
    ):
        assert again("0", *words) == 2
        assert error in capsys.readouterr().err
