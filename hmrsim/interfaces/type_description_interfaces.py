"""Descriptions of ROS types, and the service by which a node describes its types."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field as Default

from hmrsim.interfaces.message import Bool, Message, Primitive, String, UInt8, UInt64

MAX_NAME = 255
"""The largest number of characters in the name of a type."""

Name = Annotated[str, Primitive("string", MAX_NAME), Default(max_length=MAX_NAME)]


class FieldType(Message):
    """The type of a field: its number, the capacities of lists and strings, and the nested type."""

    type_id: UInt8 = 0
    capacity: UInt64 = 0
    string_capacity: UInt64 = 0
    nested_type_name: Name = ""


class Field(Message):
    """A field of a type."""

    name: String = ""
    type: FieldType = Default(default_factory=FieldType)
    default_value: String = ""


class IndividualTypeDescription(Message):
    """A type without the types that it nests."""

    type_name: Name = ""
    fields: list[Field] = Default(default_factory=list)


class TypeDescription(Message):
    """A type and all types that it nests."""

    type_description: IndividualTypeDescription = Default(default_factory=IndividualTypeDescription)
    referenced_type_descriptions: list[IndividualTypeDescription] = Default(default_factory=list)


class TypeSource(Message):
    """The file that defines a type."""

    type_name: String = ""
    encoding: String = ""
    raw_file_contents: String = ""


class KeyValue(Message):
    """A named value, as text."""

    key: String = ""
    value: String = ""


class GetTypeDescription:
    """Return the description of a type."""

    class Request(Message):
        """The type by name and hash, and whether its definition is needed, too."""

        type_name: String = ""
        type_hash: String = ""
        include_type_sources: Bool = True

    class Response(Message):
        """The description, or why there is none."""

        successful: Bool = False
        failure_reason: String = ""
        type_description: TypeDescription = Default(default_factory=TypeDescription)
        type_sources: list[TypeSource] = Default(default_factory=list)
        extra_information: list[KeyValue] = Default(default_factory=list)
