"""``hmrsim check``: searching for failures, repeating them, and applying properties to a trace."""

from __future__ import annotations

import json
import re
import shutil
from argparse import Namespace
from functools import cache

import pytest
import yaml

from hmrsim.cli import main
from hmrsim.cli.check import check_trace
from hmrsim.cli.check_runs import _write_page
from hmrsim.testing import simulation
from tests.porters import HERE, WORLD


def prepare(folder):
    (folder / "world.yaml").write_text(yaml.safe_dump(WORLD), encoding="utf-8")
    (folder / "porters.py").write_text((HERE / "porters.py").read_text("utf-8"), encoding="utf-8")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    prepare(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(*words):
    return main(["check", *words])


SERIAL = ("--executor", "hmrsim.trials.batches:Serial")


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """Return the folder of a search that has found a failure, shared by all tests."""
    home = tmp_path_factory.mktemp("searched")
    prepare(home)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(home)
        assert check("world.yaml", "--python", "porters.py:vain", "--only", "breakdown", "--runs", "40", *SERIAL) == 1
    return home


@pytest.fixture
def found(folder, searched):
    shutil.copytree(searched, folder, dirs_exist_ok=True)
    (repro,) = (folder / "porters_check" / "failures").glob("*.yaml")
    return repro


def test_failures_are_printed_and_written(folder, capsys):
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
    assert check("--repro", str(found)) == 1
    out, err = capsys.readouterr()
    assert "it fails as before: no_vain_goals: rejected 5 times in a row (with the same trace)" in out
    assert f"{found}: runs the code 'porters.py:vain'\n" == err
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "porters.py:careful"), encoding="utf-8")
    assert check("--repro", str(found)) == 0
    assert "it passes: no_vain_goals is not violated any more" in capsys.readouterr().out


def test_a_failure_whose_world_lacks_something_is_inconclusive(folder, found, capsys):
    """A changed controller that needs something that the reduced world lacks has not failed."""
    code = check("world.yaml", "--python", "porters.py:needy", "--only", "breakdown", "--runs", "40", *SERIAL)
    out, err = capsys.readouterr()

    assert code == 0, out
    assert f"set aside {found.relative_to(folder)}: its world does not fit the controller any more; " in err
    assert "without its schedule the run ends as crashed: KeyError: 'crate'" in err


def test_a_failure_by_comparison_is_repeated(folder, capsys):
    """A property that compares runs needs the run without faults."""
    then = {"reports": "succeeded", "then": {"items": "as_without_faults"}}
    (folder / "properties.yaml").write_text(yaml.safe_dump({"properties": {"true": then}}), encoding="utf-8")
    words = ("--properties", "properties.yaml", "--only", "goals_aborted", "--runs", "20")
    assert check("world.yaml", "--python", "porters.py:proud", *words, *SERIAL) == 1
    (repro,) = (folder / "porters_check" / "failures").glob("*.yaml")
    capsys.readouterr()

    assert check("--repro", str(repro)) == 1
    assert "it fails as before: true: reported succeeded, but not: all items are" in capsys.readouterr().out


def test_a_search_without_failures_reports_its_coverage(folder, capsys):
    code = check("world.yaml", "--python", "porters.py:careful", "--runs", "20", "-o", "results", "--json", *SERIAL)
    output = json.loads(capsys.readouterr().out)

    assert code == 0
    assert output["runs"] == 20
    assert output["unreached"]["singles"] > 0
    assert "orders_in_time" in output["unreached"]["properties"]
    assert json.loads((folder / "results" / "summary.json").read_text("utf-8")) == output


@pytest.mark.usefixtures("folder")
def test_a_small_budget_gives_a_warning(capsys):
    check("world.yaml", "--python", "porters.py:careful", "--runs", "5", *SERIAL)
    out = capsys.readouterr().out

    assert re.search(r"5 runs in \d+ s are far too few for this mission \(", out)
    assert " kinds of things had no turn; allow it " in out
    assert "never began" not in out


@pytest.mark.usefixtures("folder")
def test_a_search_for_the_first_failure_asks_for_no_more_runs(capsys):
    assert check("world.yaml", "--python", "porters.py:vain", "--runs", "20", "--first", *SERIAL) == 1

    assert "far too few" not in capsys.readouterr().out


@pytest.mark.usefixtures("folder")
def test_missions_that_give_up_are_counted_but_no_failures(capsys):
    words = ("--only", "goals_aborted", "goals_rejected", "--at-most", "1", "--runs", "30")
    check("world.yaml", "--python", "porters.py:hasty", *words, *SERIAL)
    out = capsys.readouterr().out

    assert re.search(r"gave up in \d+ of \d+ schedules with transient faults only, first: the ", out)


def test_options_override_the_file_of_a_check(folder, capsys):
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}, "budget": {"runs": 40}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--only", "slip", "--json", *SERIAL) == 0
    assert [*json.loads(capsys.readouterr().out)["kinds"]] == ["slip"]


@pytest.mark.parametrize(
    ("words", "message"),
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
        (("nowhere.yaml", "--python", "porters.py:vain"), "nowhere.yaml: no such file"),
        (("--repro", "nowhere.yaml"), "nowhere.yaml: no such file"),
        (
            ("world.yaml", "--python", "porters.py:broken"),
            "controller: without any fault the run ends as crashed at 0.0 s, before a goal is sent",
        ),
        (
            ("world.yaml", "--python", "porters.py:sleepy", "--budget", "0.01s"),
            "budget: the run without faults is not over after 0.01 s; give more time",
        ),
        (
            ("--trace", "run.jsonl", "--page", "a.html"),
            "--page a.html: a trace has no run beside it; `hmrsim report` shows it",
        ),
    ],
)
def test_wrong_use_is_one_line(folder, capsys, words, message):
    assert check(*words, *SERIAL) == 2
    err = capsys.readouterr().err
    assert message in err
    assert "Traceback" not in err
    assert not (folder / "porters_check").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("--tree", "mission.xml", "--set", "seed=3"),
            "check.yaml: the file of a check says that itself; leave out --tree, --set",
        ),
        (("--only", "slp"), "command line: space.only.0: no kind 'slp'; did you mean 'slip'?"),
    ],
)
def test_options_that_repeat_or_override_a_check_file_are_validated(folder, capsys, words, message):
    file = {"world": "world.yaml", "controller": {"python": "porters.py:vain"}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", *words, *SERIAL) == 2
    assert message in capsys.readouterr().err


def test_a_check_file_with_a_misspelled_controller_lists_all_its_errors(folder, capsys):
    (folder / "check.yaml").write_text("world: world.yaml\ncontroler: {python: a:b}\nbudgt: 10m\n", encoding="utf-8")

    assert check("check.yaml", *SERIAL) == 2
    err = capsys.readouterr().err
    assert "check.yaml:2: controler: unknown key 'controler'; did you mean 'controller'?" in err
    assert "check.yaml:3: budgt: unknown key 'budgt'; did you mean 'budget'?" in err


def test_an_unwritable_recording_gives_no_verdict(found, capsys):
    assert check("--repro", str(found), "--record", "world.yaml/run.mcap") == 2
    assert "can't be repeated: world.yaml/run.mcap: can't be written" in capsys.readouterr().err


@pytest.mark.usefixtures("folder")
def test_ctrl_c_before_the_first_run_exits_with_130(capsys, monkeypatch):
    def interrupted(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr("hmrsim.fault_search.evaluator.Evaluator.outcomes", interrupted)

    assert check("world.yaml", "--python", "porters.py:vain", *SERIAL) == 130
    assert "nothing was tried" in capsys.readouterr().err


def test_a_missing_controller_suggests_the_folder_option(found, capsys):
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "elsewhere.py:vain"), encoding="utf-8")
    capsys.readouterr()

    assert check("--repro", str(found)) == 2
    assert "; --folder DIR says where the controller's files are" in capsys.readouterr().err


@pytest.mark.usefixtures("folder")
def test_a_search_with_nothing_to_try_warns(capsys):
    assert check("world.yaml", "--python", "porters.py:careful", "--only", "door_jammed", "--runs", "5", *SERIAL) == 0
    assert "warning: nothing was tried" in capsys.readouterr().err


def test_a_controller_that_sends_no_goal_is_an_error(folder, capsys):
    """It looks like a controller that nothing breaks."""
    (folder / "idle.py").write_text("def idle(client):\n    return True\n", encoding="utf-8")

    assert check("world.yaml", "--python", "idle.py:idle", "--runs", "5", *SERIAL) == 2
    end = "before a goal is sent: does the controller await what it calls?; there is nothing that a fault could break"
    assert f"controller: without any fault the run ends as succeeded at 0.0 s, {end}" in capsys.readouterr().err


def test_a_controller_that_need_not_end_is_no_reason_for_a_warning(folder, capsys):
    text = "async def serves(client):\n    while True:\n        await client.robot('porter').wait(30)\n"
    (folder / "serves.py").write_text(text, encoding="utf-8")
    file = {"world": "world.yaml", "controller": {"python": "serves.py:serves"}, "limits": {"simulated": 100}}
    file |= {"properties": {"built_in": {"mission_ends": False}}, "space": {"only": ["slip"]}}
    (folder / "check.yaml").write_text(yaml.safe_dump(file), encoding="utf-8")

    assert check("check.yaml", "--runs", "2", *SERIAL) == 0
    assert "warning: without faults" not in capsys.readouterr().err


@cache
def traced() -> str:
    with simulation("hospital", tree="bt_controller.examples.hospital:mission") as run:
        run.to_the_end()
        return run.trace


@pytest.fixture
def check_run(tmp_path):
    def run(properties=None, *, as_json=False, trace=None):
        (tmp_path / "run.jsonl").write_text(traced() if trace is None else trace)
        path = None
        if properties is not None:
            path = tmp_path / "properties.yaml"
            path.write_text(json.dumps({"properties": properties}))
        return check_trace(Namespace(trace=tmp_path / "run.jsonl", properties=path, json=as_json, log_level="error"))

    return run


def test_verdicts_are_printed_as_a_table(check_run, capsys):
    code = check_run({"door": {"sometimes": {"event": "door_opened"}}})

    out = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert ["property", "verdict", "robustness"] == out[0].split()
    assert ["door", "holds", "+1.00"] == out[1].split()[:3]


def test_violations_are_listed_with_their_times(check_run, capsys):
    code = check_run({"shut": {"never": {"event": "door_opened"}}})

    output = [line.split(" s  ")[-1] for line in capsys.readouterr().out.splitlines() if " s  " in line]
    assert (1, 13) == (code, len(output))
    assert "shut: door_opened, at 22.0518 s: ward_a is open for auto" == output[0]


def test_json_has_verdicts_and_violations(check_run, capsys):
    code = check_run({"shut": {"never": {"event": "door_opened"}}}, as_json=True)

    output = json.loads(capsys.readouterr().out)
    assert 1 == code
    assert output["violated"]
    assert "shut" == output["violations"][0]["property"]
    assert "door_opened" == output["violations"][0]["reason"]
    assert "violated" == output["verdicts"][0]["state"]


def test_without_a_file_the_built_in_properties_are_checked(check_run, capsys):
    code = check_run()

    assert (0, 7) == (code, len(capsys.readouterr().out.splitlines()) - 1)


def test_a_failure_is_written_as_a_page(found, folder, capsys):
    assert check("--repro", str(found), "--page", "failure.html") == 1
    err = capsys.readouterr().err

    assert "page: failure.html\n" in err
    assert "violates no_vain_goals" in (folder / "failure.html").read_text("utf-8")


def test_a_search_writes_the_page_of_its_first_failure(folder, capsys):
    words = ("--only", "breakdown", "--runs", "40", "--page", "failure.html")
    assert check("world.yaml", "--python", "porters.py:vain", *words, *SERIAL) == 1

    assert "page: failure.html\n" in capsys.readouterr().err
    assert "Without it: it passes" in (folder / "failure.html").read_text("utf-8")


def test_a_run_that_passes_has_no_page(found, folder, capsys):
    found.write_text(found.read_text("utf-8").replace("porters.py:vain", "porters.py:careful"), encoding="utf-8")
    assert check("--repro", str(found), "--page", "failure.html") == 0
    assert check("world.yaml", "--python", "porters.py:careful", "--runs", "5", "--page", "a.html", *SERIAL) == 0
    err = capsys.readouterr().err

    assert "--page failure.html: not written, since the run passes\n" in err
    assert "--page a.html: not written, since no failure was found\n" in err
    assert not [*folder.glob("*.html")]


def test_a_page_that_can_not_be_written_is_reported_before_the_run(found, folder, capsys):
    for path in (folder / "none" / "a.html", folder):
        assert check("--repro", str(found), "--page", str(path)) == 2
        out, err = capsys.readouterr()

        assert f"--page {path}: can't be written" in err
        assert (out, "runs the code" in err) == ("", False)


def test_a_page_must_not_replace_what_is_read(found, capsys):
    assert check("--repro", str(found), "--page", str(found)) == 2

    assert "this command reads that file" in capsys.readouterr().err


def test_a_run_that_kills_its_process_has_no_page(folder, capsys):
    """To repeat it would end the command, too."""
    finding = Namespace(case=None, outcome=Namespace(ending="died"))
    _write_page(folder / "a.html", None, Namespace(findings=[finding]))

    assert "not written, since the controller kills the process of its run" in capsys.readouterr().err
