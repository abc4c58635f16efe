"""``hmrsim check``: searching for failures, repeating them, and applying properties to a trace."""

from __future__ import annotations

import json
import re
import shutil
from argparse import Namespace
from functools import cache

import pytest
import yaml

from hmrsim.cli.check import check_trace
from hmrsim.cli.entry import main
from hmrsim.errors import PropertyError, TraceError
from hmrsim.testing import simulation
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


def test_failures_are_printed_and_written(folder, capsys):
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
    """The exit code tells whether the controller still fails, until it is fixed."""
    assert check("--repro", str(found)) == 1
    out, err = capsys.readouterr()
    assert "it fails as before: no_vain_goals: rejected 5 times in a row (with the same trace)" in out
    assert f"{found}: runs the code 'porters.py:vain'\n" == err
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "porters.py:careful"), encoding="utf-8")
    assert check("--repro", str(found)) == 0
    assert "it passes: no_vain_goals is not violated any more" in capsys.readouterr().out


def test_a_failure_whose_world_does_not_fit_any_more_is_set_aside(folder, found, capsys):
    """A controller that has changed, and needs something that the reduced world lacks, has not failed."""
    code = check("world.yaml", "--python", "porters.py:needy", "--only", "breakdown", "--runs", "40", *SERIAL)
    out, err = capsys.readouterr()

    assert code == 0, out
    assert f"set aside {found.relative_to(folder)}: its world does not fit the controller any more; " in err
    assert "without its schedule the run ends as crashed: KeyError: 'crate'" in err


def test_a_function_is_a_participant_by_its_own_name(found):
    """The story of a failure names the function, not bt_controller."""
    (story,) = found.parent.glob("*.jsonl")

    assert '"vain"' in story.read_text("utf-8")
    assert "bt_controller" not in story.read_text("utf-8")


def test_a_failure_by_comparison_is_repeated(folder, capsys):
    """A property that compares runs needs the run without faults, which is made again."""
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
    """Kinds that were not tried are counted, not listed."""
    check("world.yaml", "--python", "porters.py:careful", "--runs", "5", *SERIAL)
    out = capsys.readouterr().out

    assert re.search(r"5 runs in \d+ s are far too few for this mission \(", out)
    assert " kinds of things had no turn; allow it " in out
    assert "never began" not in out


@pytest.mark.usefixtures("folder")
def test_it_counts_how_often_a_controller_gives_up(capsys):
    """A mission that gives up is counted, but it is not a failure."""
    words = ("--only", "goals_aborted", "goals_rejected", "--at-most", "1", "--runs", "30")
    check("world.yaml", "--python", "porters.py:hasty", *words, *SERIAL)
    out = capsys.readouterr().out

    assert re.search(r"gave up in \d+ of \d+ schedules with transient faults only, first: the ", out)


def test_a_controller_that_fails_before_its_first_goal_is_an_error(folder, capsys):
    """Nothing is searched, and nothing is written."""
    assert check("world.yaml", "--python", "porters.py:broken", *SERIAL) == 2
    said = "controller: without any fault the run ends as crashed at 0.0 s, before a goal is sent"
    assert said in capsys.readouterr().err
    assert not (folder / "porters_check").exists()


@pytest.mark.usefixtures("folder")
def test_a_run_that_takes_longer_than_the_budget_is_an_error(capsys):
    """The run is not reported as hung, since the search did not wait that long."""
    assert check("world.yaml", "--python", "porters.py:sleepy", "--budget", "0.01s", *SERIAL) == 2
    assert "budget: the run without faults is not over after 0.01 s; give more time" in capsys.readouterr().err


def test_options_override_the_file_of_a_check(folder, capsys):
    """The file sets the budget, and the command line overrides the space."""
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
def test_wrong_use_is_one_line_in_check(folder, capsys, words, told):
    """The exit code is 2, and there is no traceback."""
    assert check(*words) == 2
    err = capsys.readouterr().err
    assert told in err
    assert "Traceback" not in err
    assert not (folder / "porters_check").exists()


def test_the_file_of_a_check_has_its_controller(folder, capsys):
    """Options that the file sets itself are rejected, not ignored."""
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--tree", "mission.xml", "--set", "seed=3", *SERIAL) == 2
    assert "check.yaml: the file of a check says that itself; leave out --tree, --set" in capsys.readouterr().err


def test_options_over_the_file_of_a_check_are_validated(folder, capsys):
    """An unknown kind is an error, as without a file."""
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--only", "slp", *SERIAL) == 2
    assert "command line: space.only.0: nothing is called 'slp'; did you mean 'slip'?" in capsys.readouterr().err


def test_a_failure_that_can_not_be_repeated_has_not_passed(found, capsys):
    """If the recording can't be written, the command fails, and says nothing about the controller."""
    assert check("--repro", str(found), "--record", "world.yaml/run.mcap") == 2
    assert "can't be repeated: world.yaml/run.mcap: can't be written" in capsys.readouterr().err


@pytest.mark.usefixtures("folder")
def test_ctrl_c_before_the_first_run(capsys, monkeypatch):
    """The exit code is 130."""

    def interrupted(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr("hmrsim.fault_search.running.evaluator.Evaluator.outcomes", interrupted)

    assert check("world.yaml", "--python", "porters.py:vain", *SERIAL) == 130
    assert "nothing was tried" in capsys.readouterr().err


def test_a_failure_without_its_controller_says_where_it_could_be(found, capsys):
    """If the controller's file is not found, the error suggests --folder."""
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "elsewhere.py:vain"), encoding="utf-8")
    capsys.readouterr()

    assert check("--repro", str(found)) == 2
    assert "; --folder DIR says where the controller's files are" in capsys.readouterr().err


def test_a_search_with_nothing_to_try_says_so(folder, capsys):
    """A warning says that nothing was tried."""
    (folder / "idle.py").write_text("def idle(client):\n    return True\n", encoding="utf-8")

    assert check("world.yaml", "--python", "idle.py:idle", "--runs", "5", *SERIAL) == 0
    assert "warning: nothing was tried" in capsys.readouterr().err


@cache
def traced() -> str:
    """Return the trace of the hospital's mission."""
    with simulation("hospital", tree="bt_controller.examples.hospital:mission") as run:
        run.to_the_end()
        return run.trace


@pytest.fixture
def check_run(tmp_path):
    """Return the function that checks some properties on the trace."""

    def run(properties=None, *, as_json=False, trace=None):
        (tmp_path / "run.jsonl").write_text(traced() if trace is None else trace)
        path = None
        if properties is not None:
            path = tmp_path / "properties.yaml"
            path.write_text(json.dumps({"properties": properties}))
        return check_trace(Namespace(trace=tmp_path / "run.jsonl", properties=path, json=as_json, log_level="error"))

    return run


def test_verdicts_are_a_table(check_run, capsys):
    """Each property has a line: its verdict, its robustness, and why; the exit code is 0."""
    code = check_run({"door": {"sometimes": {"event": "door_opened"}}})

    out = capsys.readouterr().out.splitlines()
    assert (0, ["property", "verdict", "robustness"], ["door", "holds", "+1.00"]) == (
        code,
        out[0].split(),
        out[1].split()[:3],
    )


def test_violations_are_listed_with_their_times(check_run, capsys):
    """A violated property makes the exit code 1, and each violation is a line with its time."""
    code = check_run({"shut": {"never": {"event": "door_opened"}}})

    said = [line.split(" s  ")[-1] for line in capsys.readouterr().out.splitlines() if " s  " in line]
    assert (1, ["shut: door_opened"] * 13) == (code, said)


def test_json_has_all_of_it(check_run, capsys):
    """``--json`` prints one object."""
    code = check_run({"shut": {"never": {"event": "door_opened"}}}, as_json=True)

    said = json.loads(capsys.readouterr().out)
    assert (1, True, "shut", "door_opened", "violated") == (
        code,
        said["violated"],
        said["violations"][0]["property"],
        said["violations"][0]["reason"],
        said["verdicts"][0]["state"],
    )


def test_without_a_file_the_built_in_properties_are_checked(check_run, capsys):
    """The built-in properties need no file."""
    code = check_run()

    assert (0, 7) == (code, len(capsys.readouterr().out.splitlines()) - 1)


def test_names_that_the_world_lacks_are_errors(check_run):
    """The error names the file and the known names."""
    with pytest.raises(PropertyError, match=r"properties\.x\.never\.robot: no robot 'eva'; did you mean 'eve'\?"):
        check_run({"x": {"never": {"robot": "eva", "at": "lab"}}})


def test_a_property_without_meaning_is_a_warning(check_run, capsys):
    """A property without meaning in this world is a warning on stderr."""
    check_run({"x": {"never": {"event": "lift_called"}}})

    assert "warning: properties.x.never.event: lift_called never comes in this world" in capsys.readouterr().err


def test_another_file_is_an_error(check_run):
    """The error has the file's name."""
    with pytest.raises(TraceError, match=r"run\.jsonl: line 1: no header of a trace"):
        check_run(trace="hello\n")
