"""Validation that continues after an error."""

from __future__ import annotations

from pydantic import BaseModel, Field

from hmrsim.documents.valid_parts import UNRESOLVED, Lost, valid_parts


class Robot(BaseModel, extra="forbid"):
    at: str
    speed: float = 1.0


class Fleet(BaseModel, extra="forbid"):
    robots: dict[str, Robot] = Field(min_length=1)
    lanes: tuple[Robot, ...] = ()


def read(data, **stand_ins):
    return valid_parts(data, Fleet, stand_ins={("robots", "*", name): value for name, value in stand_ins.items()})


def test_only_the_invalid_parts_are_removed():
    valid = read({"robots": {"eve": {"at": "lab", "speed": "fast"}, "auto": {"speed": 2}, "m_o": {"at": "lab"}}})

    assert {"eve": Robot(at="lab"), "m_o": Robot(at="lab")} == valid.value.robots
    assert [("robots", "eve", "speed"), ("robots", "auto", "at")] == [finding.path for finding in valid.findings]


def test_an_entry_that_is_removed_has_all_its_errors():
    valid = read({"robots": {"eve": {"att": "lab", "speed": "fast"}, "m_o": {"at": "lab"}}})

    assert {("robots", "eve", step) for step in ("at", "att", "speed")} == {finding.path for finding in valid.findings}
    assert ["m_o"] == [*valid.value.robots]


def test_an_error_that_follows_from_a_removed_part_is_not_reported():
    valid = read({"robots": {"eve": {"at": 5}}})

    assert [("robots", "eve", "at")] == [finding.path for finding in valid.findings]


def test_a_stand_in_keeps_the_rest_of_an_entry():
    valid = read({"robots": {"eve": {"at": 5, "speed": 2}, "auto": {"speed": 3}}}, at=UNRESOLVED)

    assert {"eve": 2, "auto": 3} == {name: robot.speed for name, robot in valid.value.robots.items()}
    assert [("robots", "eve", "at"), ("robots", "auto", "at")] == [finding.path for finding in valid.findings]


def test_paths_lead_to_the_original_entries_of_a_list():
    valid = read({"robots": {"eve": {"at": "lab"}}, "lanes": [{"at": "a"}, {"at": 5}, {"at": "c"}]})

    assert {"lanes": (0, 2)} == valid.kept
    assert valid.lost.touches("lanes")


def test_invalid_entries_are_lost():
    lost = read({"robots": {"eve": {"at": "lab", "speed": "fast"}, "m_o": {"at": "lab"}}}).lost

    assert lost.has("eve", "robots")
    assert not lost.has("m_o", "robots")
    assert lost.has(UNRESOLVED)
    assert not Lost()


def test_a_name_that_equals_a_stand_in_is_like_any_other_in_a_valid_document():
    assert not read({"robots": {"eve": {"at": UNRESOLVED}}}).lost.has(UNRESOLVED, "robots")


def test_a_misspelled_key_has_the_entries_of_the_key_that_is_meant():
    lost = read({"robots": {"eve": {"at": "lab"}}, "lane": [{"at": "a"}]}).lost

    assert lost.touches("lanes")
    assert not lost.touches("robots")


def test_without_a_valid_part_there_are_only_errors():
    valid = read({"robots": 5})

    assert None is valid.value
    assert [("robots",)] == [finding.path for finding in valid.findings]
