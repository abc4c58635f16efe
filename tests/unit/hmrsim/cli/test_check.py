"""`hmrsim check` from the command line: what it prints, writes, and returns."""

from __future__ import annotations

import json
import re
import shutil

import pytest
import yaml

from hmrsim.cli.entry import main
from tests.porters import HERE, WORLD


def prepare(folder):
    """Write a world and its controllers."""
    (folder / "world.yaml").write_text(yaml.safe_dump(WORLD), encoding="utf-8")
    (folder / "porters.py").write_text((HERE / "porters.py").read_text("utf-8"), encoding="utf-8")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with a world and its controllers, which is the current one."""
    prepare(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(*words):
    """Run the command within this process; return its exit code."""
    return main(["check", *words])


SERIAL = ("--executor", "hmrsim.trials.batches:Serial")


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """Return the folder of a search that has found a failure, which is made once."""
    home = tmp_path_factory.mktemp("searched")
    prepare(home)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(home)
        assert check("world.yaml", "--python", "porters.py:vain", "--only", "breakdown", "--runs", "40", *SERIAL) == 1
    return home


@pytest.fixture
def found(folder, searched):
    """Return the file of a failure that a search has found in the current folder."""
    shutil.copytree(searched, folder, dirs_exist_ok=True)
    (repro,) = (folder / "porters_check" / "failures").glob("*.yaml")
    return repro


def test_what_is_found_is_told_and_written(folder, capsys):
    """The exit code is 1; each failure has a file, and the page, JUnit XML and a summary are there."""
    code = check("world.yaml", "--python", "porters.py:vain", "--only", "breakdown", "--runs", "40", *SERIAL)
    out, err = capsys.readouterr()

    assert code == 1
    assert out.startswith("porters: 1 failure in 40 runs")
    assert "   - breakdown of porter for 1 s, when " in out
    assert "found after " in err
    (repro,) = (folder / "porters_check" / "failures").glob("*.yaml")
    assert f"hmrsim check --repro {repro.relative_to(folder)}" in out
    assert {"report.html", "junit.xml", "summary.json"} <= {path.name for path in repro.parents[1].iterdir()}


def test_a_failure_is_repeated(found, capsys):
    """Until the controller is mended: the exit code says whether it still fails."""
    assert check("--repro", str(found)) == 1
    out, err = capsys.readouterr()
    assert "it fails as before: no_vain_goals: rejected 5 times in a row (with the same trace)" in out
    assert f"{found}: runs the code 'porters.py:vain'\n" == err
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "porters.py:careful"), encoding="utf-8")
    assert check("--repro", str(found)) == 0
    assert "it passes: no_vain_goals is not violated any more" in capsys.readouterr().out


def test_a_failure_whose_world_does_not_fit_any_more_is_set_aside(folder, found, capsys):
    """The controller is another one by now, and needs what was left out; it is not accused of that."""
    code = check("world.yaml", "--python", "porters.py:needy", "--only", "breakdown", "--runs", "40", *SERIAL)
    out, err = capsys.readouterr()

    assert code == 0, out
    assert f"set aside {found.relative_to(folder)}: its world does not fit the controller any more; " in err
    assert "without its schedule the run ends as crashed: KeyError: 'crate'" in err


def test_a_function_is_a_participant_by_its_own_name(found):
    """A story that speaks of bt_controller speaks of nobody."""
    (story,) = found.parent.glob("*.jsonl")

    assert '"vain"' in story.read_text("utf-8")
    assert "bt_controller" not in story.read_text("utf-8")


def test_a_failure_is_repeated_that_is_one_by_comparison(folder, capsys):
    """The run without faults is made once more for it."""
    then = {"reports": "succeeded", "then": {"items": "as_without_faults"}}
    (folder / "properties.yaml").write_text(yaml.safe_dump({"properties": {"true": then}}), encoding="utf-8")
    words = ("--properties", "properties.yaml", "--only", "goals_aborted", "--runs", "20")
    assert check("world.yaml", "--python", "porters.py:proud", *words, *SERIAL) == 1
    (repro,) = (folder / "porters_check" / "failures").glob("*.yaml")
    capsys.readouterr()

    assert check("--repro", str(repro)) == 1
    assert "it fails as before: true: reported succeeded, but not: all items are" in capsys.readouterr().out


def test_a_search_that_finds_nothing_says_what_it_did_not_reach(folder, capsys):
    """The exit code is 0."""
    code = check("world.yaml", "--python", "porters.py:careful", "--runs", "20", "-o", "results", "--json", *SERIAL)
    said = json.loads(capsys.readouterr().out)

    assert code == 0
    assert said["runs"] == 20
    assert said["unreached"]["singles"] > 0
    assert "orders_in_time" in said["unreached"]["properties"]
    assert json.loads((folder / "results" / "summary.json").read_text("utf-8")) == said


@pytest.mark.usefixtures("folder")
def test_a_few_runs_say_that_they_are_far_too_few(capsys):
    """Kinds that had no turn are counted and not listed."""
    check("world.yaml", "--python", "porters.py:careful", "--runs", "5", *SERIAL)
    out = capsys.readouterr().out

    assert re.search(r"5 runs in \d+ s are far too few for this mission \(", out)
    assert " kinds of things had no turn; allow it " in out
    assert "never began" not in out


@pytest.mark.usefixtures("folder")
def test_how_often_a_controller_gives_up_is_told(capsys):
    """Though a mission that fails, and says so, is no failure."""
    words = ("--only", "goals_aborted", "goals_rejected", "--at-most", "1", "--runs", "30")
    check("world.yaml", "--python", "porters.py:hasty", *words, *SERIAL)
    out = capsys.readouterr().out

    assert re.search(r"gave up in \d+ of \d+ schedules with transient faults only, first: the ", out)


def test_a_controller_that_fails_before_its_first_goal_is_an_error(folder, capsys):
    """Nothing is searched for, and nothing written."""
    assert check("world.yaml", "--python", "porters.py:broken", *SERIAL) == 2
    said = "controller: without any fault the run ends as crashed at 0.0 s, before a goal is sent"
    assert said in capsys.readouterr().err
    assert not (folder / "porters_check").exists()


@pytest.mark.usefixtures("folder")
def test_a_run_that_takes_longer_than_the_budget_is_an_error(capsys):
    """It is not told as hung, for which nobody has waited."""
    assert check("world.yaml", "--python", "porters.py:sleepy", "--budget", "0.01s", *SERIAL) == 2
    assert "budget: the run without faults is not over after 0.01 s; give more time" in capsys.readouterr().err


def test_the_file_of_a_check_has_it_all_and_options_come_before_it(folder, capsys):
    """Here the file says how long, and the command line what."""
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}, "budget": {"runs": 40}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--only", "slip", "--json", *SERIAL) == 0
    assert [*json.loads(capsys.readouterr().out)["kinds"]] == ["slip"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "expected a world or the file of a check, --repro FILE or --trace TRACE"),
        (("world.yaml",), "expected one of --tree, --python and --command, or the file of a check"),
        (("world.yaml", "--python", "porters.py:nothing"), "nothing"),
        (
            ("world.yaml", "--python", "porters.py:vain", "--budget", "soon"),
            "command line: budget.time: expected a time such as 90s, 10m or 1h, got 'soon'",
        ),
        (
            ("world.yaml", "--tree", "bt_controller.examples.hospital:mission", "--robots", "portr"),
            "controller.robots.0: no robot 'portr'; did you mean 'porter'?",
        ),
        (("world.yaml", "--python", "porters.py:vain", "-o", "world.yaml"), "world.yaml: is a file; expected a folder"),
        (
            ("world.yaml", "--python", "porters.py:vain", "--record", "a.mcap"),
            "--record a.mcap: it is for --repro alone",
        ),
        (("--repro", "a.yaml", "--trace", "b.jsonl"), "--repro and --trace"),
        (("world.yaml", "--trace", "b.jsonl"), "world.yaml: a world is of no use with --trace"),
        (("--trace", "b.jsonl", "--tree", "a.xml"), "--trace: its file says what was run; leave out --tree"),
        (("--repro", "world.yaml"), "world.yaml: is not the file of a failure"),
        (("--repro", "world.yaml", "--folder", "nowhere"), "--folder nowhere: no such folder"),
        (("world.yaml", "--command", "./nothing"), "command line: controller: ./nothing: No such file or directory"),
        (
            ("world.yaml", "--python", "porters.py:vain", "--only", "slp"),
            "nothing is called 'slp'; did you mean 'slip'?",
        ),
        (("nowhere.yaml", "--python", "porters.py:vain"), "nowhere.yaml: no such file"),
        (("--repro", "nowhere.yaml"), "nowhere.yaml: no such file"),
    ],
)
def test_wrong_use_is_told_on_a_line(folder, capsys, words, told):
    """The exit code is 2, and there is no traceback."""
    assert check(*words) == 2
    err = capsys.readouterr().err
    assert told in err
    assert "Traceback" not in err
    assert not (folder / "porters_check").exists()


def test_the_file_of_a_check_has_its_controller(folder, capsys):
    """Options that say the same are refused, not ignored."""
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--tree", "mission.xml", "--set", "seed=3", *SERIAL) == 2
    assert "check.yaml: the file of a check says that itself; leave out --tree, --set" in capsys.readouterr().err


def test_options_over_the_file_of_a_check_are_looked_at(folder, capsys):
    """A kind that there is not is told as it is without a file; the search would have had nothing to try."""
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--only", "slp", *SERIAL) == 2
    assert "command line: space.only.0: nothing is called 'slp'; did you mean 'slip'?" in capsys.readouterr().err


def test_a_failure_that_can_not_be_repeated_has_not_passed(found, capsys):
    """The recording can't be written: that is an error, and says nothing about the controller."""
    assert check("--repro", str(found), "--record", "world.yaml/run.mcap") == 2
    assert "can't be repeated: world.yaml/run.mcap: can't be written" in capsys.readouterr().err


@pytest.mark.usefixtures("folder")
def test_ctrl_c_before_the_first_run_is_told(capsys, monkeypatch):
    """The exit code is 130."""

    def interrupted(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr("hmrsim.fault_search.running.evaluator.Evaluator.outcomes", interrupted)

    assert check("world.yaml", "--python", "porters.py:vain", *SERIAL) == 130
    assert "nothing was tried" in capsys.readouterr().err


def test_a_failure_without_its_controller_says_where_it_could_be(found, capsys):
    """It was moved, and the controller's file is neither beside it nor in the current folder."""
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "elsewhere.py:vain"), encoding="utf-8")
    capsys.readouterr()

    assert check("--repro", str(found)) == 2
    assert "; --folder DIR says where the controller's files are" in capsys.readouterr().err


def test_a_search_with_nothing_to_try_says_so(folder, capsys):
    """That nothing was found says nothing then."""
    (folder / "idle.py").write_text("def idle(client):\n    return True\n", encoding="utf-8")

    assert check("world.yaml", "--python", "idle.py:idle", "--runs", "5", *SERIAL) == 0
    assert "warning: nothing was tried" in capsys.readouterr().err
