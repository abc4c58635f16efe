"""The ROS 2 wires of ``hmrsim run``, by its options and the environment."""

from __future__ import annotations

import pytest

from hmrsim.cli import main
from hmrsim.cli.run import ros2_wires
from hmrsim.program.command_line import CommandParser
from hmrsim.settings.arguments import add_settings, read_settings
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds
from hmrsim_zenoh.settings import Ros2Settings


@pytest.fixture(autouse=True)
def _no_domain(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def wires(*words):
    parser = CommandParser()
    add_settings(parser, Ros2Settings)
    return ros2_wires(read_settings(parser.parse_args(words), Ros2Settings))


DISTROS = ("--ros-distro", "lyrical", "--ros-distro", "jazzy", "--ros-distro", "lyrical")


@pytest.mark.parametrize(
    ("words", "domain", "expected"),
    [
        ((), None, ()),
        (("--ros2",), None, (RmwZenoh(0, ("jazzy", "kilted", "lyrical", "rolling")),)),
        (("--ros2",), "7", (RmwZenoh(7),)),
        (("--ros2", "--ros-domain-id", "8"), "7", (RmwZenoh(8),)),
        (("--ros2", "--ros2dds", *DISTROS), None, (RmwZenoh(0, ("lyrical", "jazzy")), Ros2Dds("lyrical"))),
        (("--ros2dds",), None, (Ros2Dds("jazzy"),)),
    ],
    ids=["none", "all distributions", "ROS_DOMAIN_ID", "an option first", "some distributions", "the bridge"],
)
def test_options_and_environment_choose_the_wires(monkeypatch, words, domain, expected):
    if domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", domain)

    assert expected == wires(*words)


def test_an_invalid_ros_domain_id_is_an_error(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "lab")

    expected = (
        "ROS_DOMAIN_ID: 'lab' is not a domain id; expected a whole number from 0 to 232; correct it, or give "
        "--ros-domain-id"
    )
    with pytest.raises(BadOptions, match=f"^{expected}$"):
        wires("--ros2")


def test_variables_of_ros_runs_are_ignored_in_other_runs(monkeypatch):
    monkeypatch.setenv("HMRSIM_ROS_DOMAIN_ID", "7")
    monkeypatch.setenv("HMRSIM_ROS_DISTRO", "jazzy")

    assert () == wires()
    assert (RmwZenoh(7, ("jazzy",)),) == wires("--ros2")
    assert (Ros2Dds("jazzy"),) == wires("--ros2dds")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--ros-domain-id", "3"), "hmrsim: --ros-domain-id is for --ros2; add that\n"),
        (("--ros-domain-id", "3", "--ros2dds"), "hmrsim: --ros-domain-id is for --ros2; add that\n"),
        (("--ros-distro", "jazzy"), "hmrsim: --ros-distro is for --ros2 and --ros2dds; add one of them\n"),
        (("--ros2", "--ros-distro", "foxy"), "no ros-distro 'foxy'; there are jazzy, kilted, lyrical, rolling"),
        (
            ("--ros2", "--ros-domain-id", "233"),
            "--ros-domain-id: '233' is not a domain id; expected a whole number from 0 to 232",
        ),
        (("--ros2", "--ros-domain-id", "7" * 5000), "--ros-domain-id: '77777777777777777777' is not a domain id"),
    ],
    ids=["no wire", "another wire", "no wire of a distribution", "no distribution", "no domain", "a long domain"],
)
def test_invalid_options_exit_with_2(words, message, capsys):
    assert 2 == main(["run", "scenario1", *words])
    assert message in capsys.readouterr().err
