"""Fault search in tests, whose errors are those of the command line."""

from __future__ import annotations

import pytest

from hmrsim.errors import CheckError
from hmrsim.testing import check, schedules
from tests.porters import WORLD


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ({"budget": "soon", "tree": "a.xml"}, "budget.time: expected a time such as 90s, 10m or 1h, got 'soon'"),
        ({"budget": "1s"}, "controller: expected one of tree, python and command"),
        ({"budget": "1s", "tree": "nothing.xml"}, "controller: nothing.xml: no such file"),
    ],
)
def test_a_check_that_is_wrong_is_told_on_a_line(said, told):
    @check(WORLD, **said)
    def searching():
        """Fail before anything is run."""

    with pytest.raises(CheckError) as error:
        searching()
    assert str(error.value) == f"hmrsim.testing.check: {told}"


def test_schedules_of_a_tree_that_there_is_not():
    with pytest.raises(CheckError, match=r"^hmrsim\.testing\.schedules: controller: nothing\.xml: no such file$"):
        schedules(WORLD, tree="nothing.xml")


def test_the_results_are_those_that_the_command_writes(tmp_path):
    @check("zoo/crossing", tree="bt_controller.examples:go_to_pose", runs=1, output=tmp_path)
    def searching():
        """It is given no summary."""

    searching()

    assert ["coverage.json", "junit.xml", "report.html", "summary.json"] == sorted(
        each.name for each in tmp_path.iterdir()
    )


def test_only_the_named_robots_run_a_tree():

    @check("cafe", tree="bt_controller.examples:go_to_pose", robots=["nobody"], runs=1)
    def searching():
        """Fail before anything is run."""

    with pytest.raises(CheckError, match="no robot 'nobody'"):
        searching()
