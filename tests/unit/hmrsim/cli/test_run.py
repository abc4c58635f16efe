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
    """Unset the ROS domain of the user's shell."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def wires(*words):
    """Return the wires of a command line."""
    parser = CommandParser()
    add_settings(parser, Ros2Settings)
    return ros2_wires(read_settings(parser.parse_args(words), Ros2Settings))


def test_none():
    """Without an option there is no ROS wire, whatever the environment says."""
    assert () == wires()


def test_ros2():
    """By default, all distributions are served on domain 0."""
    assert (RmwZenoh(0, ("jazzy", "kilted", "lyrical")),) == wires("--ros2")


def test_the_domain_of_the_environment(monkeypatch):
    """ROS_DOMAIN_ID is the default domain."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")

    assert (RmwZenoh(7),) == wires("--ros2")


def test_the_option_comes_before_the_environment(monkeypatch):
    """The option takes precedence over the environment."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")

    assert (RmwZenoh(8),) == wires("--ros2", "--ros-domain-id", "8")


def test_some_distributions():
    """Named distributions are served once each."""
    words = ("--ros-distro", "lyrical", "--ros-distro", "jazzy", "--ros-distro", "lyrical")

    assert (RmwZenoh(0, ("lyrical", "jazzy")), Ros2Dds("lyrical")) == wires("--ros2", "--ros2dds", *words)


def test_ros2dds():
    """The wire for the bridge uses jazzy by default."""
    assert (Ros2Dds("jazzy"),) == wires("--ros2dds")


def test_a_domain_of_the_environment_that_is_none(monkeypatch):
    """The error says what is expected."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "lab")

    expected = (
        "ROS_DOMAIN_ID: 'lab' is not a domain id; expected a whole number from 0 to 232; correct it, or give "
        "--ros-domain-id"
    )
    with pytest.raises(BadOptions, match=f"^{expected}$"):
        wires("--ros2")


def test_a_domain_that_is_none_is_2(capsys):
    """Domain ids end at 232."""
    code = main(["run", "scenario1", "--ros2", "--ros-domain-id", "233"])

    assert 2 == code
    assert "--ros-domain-id: '233' is not a domain id; expected a whole number from 0 to 232" in capsys.readouterr().err


def test_a_domain_of_thousands_of_digits_is_2(capsys):
    """It is rejected without being converted to a number."""
    code = main(["run", "scenario1", "--ros2", "--ros-domain-id", "7" * 5000])

    assert 2 == code
    assert "--ros-domain-id: '77777777777777777777' is not a domain id" in capsys.readouterr().err


def test_variables_of_ros_runs_are_ignored_in_other_runs(monkeypatch):
    """Variables of ROS runs don't prevent a run without ROS."""
    monkeypatch.setenv("HMRSIM_ROS_DOMAIN_ID", "7")
    monkeypatch.setenv("HMRSIM_ROS_DISTRO", "jazzy")

    assert () == wires()
    assert (RmwZenoh(7, ("jazzy",)),) == wires("--ros2")
    assert (Ros2Dds("jazzy"),) == wires("--ros2dds")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--ros-domain-id", "3"), "hmrsim: --ros-domain-id is for --ros2; add that\n"),
        (("--ros-domain-id", "3", "--ros2dds"), "hmrsim: --ros-domain-id is for --ros2; add that\n"),
        (("--ros-distro", "jazzy"), "hmrsim: --ros-distro is for --ros2 and --ros2dds; add one of them\n"),
    ],
)
def test_options_without_their_wire_are_2(words, said, capsys):
    """The error says which option to add."""
    code = main(["run", "scenario1", *words])

    assert (2, said) == (code, capsys.readouterr().err)


def test_an_unknown_distribution_is_2(capsys):
    """The error lists the known distributions."""
    code = main(["run", "scenario1", "--ros2", "--ros-distro", "foxy"])

    assert 2 == code
    assert "no ros-distro 'foxy'; there are jazzy, kilted, lyrical" in capsys.readouterr().err
