"""Loading another world."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.message import Bool, Message, String
from hmrsim.interfaces.simulation_interfaces.messages import Result, TagsFilter, WorldResource


class LoadWorld:
    """Replace the world."""

    class Request(Message):
        """By which: a file or a name, or else the world's text itself."""

        uri: String = ""
        resource_string: String = ""
        fail_on_unsupported_element: Bool = False
        ignore_missing_or_unsupported_assets: Bool = False

    class Response(Message):
        """What came of it, and the world that is there now."""

        UNSUPPORTED_FORMAT: ClassVar[int] = 101
        NO_RESOURCE: ClassVar[int] = 102
        RESOURCE_PARSE_ERROR: ClassVar[int] = 103
        MISSING_ASSETS: ClassVar[int] = 104
        UNSUPPORTED_ASSETS: ClassVar[int] = 105
        UNSUPPORTED_ELEMENTS: ClassVar[int] = 106

        result: Result = Field(default_factory=Result)
        world: WorldResource = Field(default_factory=WorldResource)


class GetCurrentWorld:
    """Ask for the world that is there."""

    class Request(Message):
        """Nothing more."""

    class Response(Message):
        """The world."""

        NO_WORLD_LOADED: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)
        world: WorldResource = Field(default_factory=WorldResource)


class GetAvailableWorlds:
    """Ask which worlds could be loaded."""

    class Request(Message):
        """Where to look for more, and of which tags."""

        additional_sources: list[String] = Field(default_factory=list)
        filter: TagsFilter = Field(default_factory=TagsFilter)
        offline_only: Bool = False
        continue_on_error: Bool = False

    class Response(Message):
        """Which."""

        DEFAULT_SOURCES_FAILED: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)
        worlds: list[WorldResource] = Field(default_factory=list)
