"""Log messages, and the parameters of nodes with their values, descriptions and services."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Array, Bool, Byte, Float64, Int64, Message, String, UInt8, UInt32, UInt64

MAX_RANGES = 1
"""The largest number of ranges in a description."""


class Log(Message):
    """A line of a node's log: time, severity, logger, text, and the place in the source."""

    DEBUG: ClassVar[int] = 10
    INFO: ClassVar[int] = 20
    WARN: ClassVar[int] = 30
    ERROR: ClassVar[int] = 40
    FATAL: ClassVar[int] = 50

    stamp: Time = Field(default_factory=Time)
    level: UInt8 = 0
    name: String = ""
    msg: String = ""
    file: String = ""
    function: String = ""
    line: UInt32 = 0


class ParameterValue(Message):
    """The value of a parameter, in the field that belongs to its type."""

    type: UInt8 = 0
    bool_value: Bool = False
    integer_value: Int64 = 0
    double_value: Float64 = 0.0
    string_value: String = ""
    byte_array_value: list[Byte] = Field(default_factory=list)
    bool_array_value: list[Bool] = Field(default_factory=list)
    integer_array_value: list[Int64] = Field(default_factory=list)
    double_array_value: list[Float64] = Field(default_factory=list)
    string_array_value: list[String] = Field(default_factory=list)

    NOT_SET: ClassVar[int] = 0
    BOOL: ClassVar[int] = 1
    INTEGER: ClassVar[int] = 2
    DOUBLE: ClassVar[int] = 3
    STRING: ClassVar[int] = 4
    BYTE_ARRAY: ClassVar[int] = 5
    BOOL_ARRAY: ClassVar[int] = 6
    INTEGER_ARRAY: ClassVar[int] = 7
    DOUBLE_ARRAY: ClassVar[int] = 8
    STRING_ARRAY: ClassVar[int] = 9


class Parameter(Message):
    """A parameter: its name and value."""

    name: String = ""
    value: ParameterValue = Field(default_factory=ParameterValue)


class FloatingPointRange(Message):
    """The valid range of a number."""

    from_value: Float64 = 0.0
    to_value: Float64 = 0.0
    step: Float64 = 0.0


class IntegerRange(Message):
    """The valid range of an integer."""

    from_value: Int64 = 0
    to_value: Int64 = 0
    step: UInt64 = 0


class ParameterDescriptor(Message):
    """The description of a parameter."""

    name: String = ""
    type: UInt8 = 0
    description: String = ""
    additional_constraints: String = ""
    read_only: Bool = False
    dynamic_typing: Bool = False
    floating_point_range: Annotated[
        list[FloatingPointRange], Array(MAX_RANGES, bounded=True), Field(max_length=MAX_RANGES)
    ] = Field(default_factory=list)
    integer_range: Annotated[list[IntegerRange], Array(MAX_RANGES, bounded=True), Field(max_length=MAX_RANGES)] = Field(
        default_factory=list
    )


class SetParametersResult(Message):
    """The outcome of setting a parameter, with the reason if it was not set."""

    successful: Bool = False
    reason: String = ""


class ListParametersResult(Message):
    """The names of parameters, and the prefixes before the last dot of each name."""

    names: list[String] = Field(default_factory=list)
    prefixes: list[String] = Field(default_factory=list)


class GetParameters:
    """Return the values of parameters."""

    class Request(Message):
        """The names of the parameters."""

        names: list[String] = Field(default_factory=list)

    class Response(Message):
        """The values, in the same order."""

        values: list[ParameterValue] = Field(default_factory=list)


class GetParameterTypes:
    """Return the types of parameters."""

    class Request(Message):
        """The names of the parameters."""

        names: list[String] = Field(default_factory=list)

    class Response(Message):
        """The types, in the same order."""

        types: list[UInt8] = Field(default_factory=list)


class DescribeParameters:
    """Return the descriptions of parameters."""

    class Request(Message):
        """The names of the parameters."""

        names: list[String] = Field(default_factory=list)

    class Response(Message):
        """The descriptions, in the same order."""

        descriptors: list[ParameterDescriptor] = Field(default_factory=list)


class ListParameters:
    """List the names of parameters."""

    class Request(Message):
        """Prefixes of the names, and the number of further dots allowed."""

        DEPTH_RECURSIVE: ClassVar[int] = 0

        prefixes: list[String] = Field(default_factory=list)
        depth: UInt64 = 0

    class Response(Message):
        """The names of the parameters."""

        result: ListParametersResult = Field(default_factory=ListParametersResult)


class SetParameters:
    """Set parameters one by one."""

    class Request(Message):
        """The parameters with their new values."""

        parameters: list[Parameter] = Field(default_factory=list)

    class Response(Message):
        """The outcomes, in the same order."""

        results: list[SetParametersResult] = Field(default_factory=list)


class SetParametersAtomically:
    """Set all parameters, or none."""

    class Request(Message):
        """The parameters with their new values."""

        parameters: list[Parameter] = Field(default_factory=list)

    class Response(Message):
        """The outcome, the same for all parameters."""

        result: SetParametersResult = Field(default_factory=SetParametersResult)
