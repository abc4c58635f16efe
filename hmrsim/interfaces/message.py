"""The base model of ROS messages, and ROS's primitive types.

A message is a pydantic model named as in ROS, in a module named as its ROS package.
Actions and services nest theirs as rclpy does: ``NavigateToPose.Goal``, ``CancelGoal.Request``.
A field left out has its ROS default. An unknown field, a wrong type, NaN or infinity is an error.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from pydantic.fields import FieldInfo

_KINDS = {"Goal": "action", "Result": "action", "Feedback": "action", "Request": "srv", "Response": "srv"}


@dataclass(frozen=True)
class Primitive:
    """The ROS primitive type of an annotated Python type.

    Attributes:
        capacity: The largest length of a bounded string; 0 for any other type.
    """

    name: str
    capacity: int = 0


@dataclass(frozen=True)
class Array:
    """Marks a list as a ROS array of fixed size or as a bounded sequence.

    Attributes:
        size: Number of items; the maximum if *bounded*.
        bounded: True for ``T[<=size]``, False for ``T[size]``.
    """

    size: int
    bounded: bool = False


class Message(BaseModel):
    """A ROS message: immutable, strict, and built (as a validator) when first used."""

    # Values are not cached: most strings that clients send are ids, and each id comes once.
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, defer_build=True, allow_inf_nan=False, cache_strings="keys"
    )

    ros_type: ClassVar[str] = ""
    """The ROS type name, such as ``geometry_msgs/msg/Pose`` or ``nav2_msgs/action/Wait_Goal``."""

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: object) -> None:
        """Derive the ROS type name from the names of the module and the class."""
        super().__pydantic_init_subclass__(**kwargs)
        package = cls.__module__.rpartition(".")[2]
        kind = _KINDS.get(cls.__name__, "msg") if "." in cls.__qualname__ else "msg"
        cls.ros_type = f"{package}/{kind}/{cls.__qualname__.replace('.', '_')}"
        for name, field in cls.model_fields.items():
            if not _is_of_ros(field.annotation, field.metadata):
                text = "use a Message, or one of hmrsim.interfaces.message, such as UInt16 or Float64"
                raise TypeError(f"{cls.ros_type}: field {name!r} has no ROS type; {text}")
            make: Any = field.default_factory
            if is_message(make) and not _has_list(make):
                # Messages are immutable, so that all can share one default; lists in them are not.
                field.default_factory = cache(make)


def _is_of_ros(annotation: Any, metadata: Iterable[object]) -> bool:
    """Return whether a field is a message, a primitive of ROS, or a list of those."""
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
    if get_origin(annotation) is list:
        return _is_of_ros(get_args(annotation)[0], ())
    return is_message(annotation) or any(isinstance(mark, Primitive) for mark in metadata)


def is_message(kind: Any) -> bool:
    """Return whether an annotation is a type of message."""
    return isinstance(kind, type) and issubclass(kind, Message)


def _has_list(message: Any) -> bool:
    kinds = [field.annotation for field in message.model_fields.values()]
    return any(get_origin(kind) is list or (is_message(kind) and _has_list(kind)) for kind in kinds)


def complete(message: Message) -> None:
    """Mark all fields of a message as set, as in a message received over a network."""
    shape = _shape(type(message))
    message.__pydantic_fields_set__.update(shape.names)
    for at, names in shape.inner:
        at(message).__pydantic_fields_set__.update(names)
    for at in shape.lists:
        for item in at(message):
            complete(item)


def lists_messages(message: Message) -> bool:
    """Return whether a message has a non-empty list of messages, so that it may be large."""
    # A loop takes a fifth of the time of `any`, and this is asked for each result.
    for at in _shape(type(message)).lists:  # noqa: SIM110
        if at(message):
            return True
    return False


class _Shape(NamedTuple):
    """The names of a message's fields, its nested messages with their names, and its lists of messages."""

    names: frozenset[str]
    inner: list[tuple[Callable[[Any], Any], frozenset[str]]]
    lists: list[Callable[[Any], Any]]


@cache
def _shape(kind: type[Message]) -> _Shape:
    shape = _Shape(frozenset(kind.model_fields), [], [])
    for path, of in _messages_in(kind):
        if get_origin(of) is list:
            shape.lists.append(attrgetter(path))
        else:
            shape.inner.append((attrgetter(path), frozenset(of.model_fields)))
    return shape


def _messages_in(kind: type[Message], path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the path and the type of each message, and of each list of messages, in a message."""
    for name, field in kind.model_fields.items():
        of: Any = field.annotation
        item = get_args(of)[0] if get_origin(of) is list else of
        if is_message(item):
            yield path + name, of
            if item is of:
                yield from _messages_in(item, f"{path}{name}.")


def unbuilt(message: type[Message], **fields: Any) -> dict[str, Any]:
    """Return the plain values of a message with the given fields, and with defaults for all others.

    The message is neither validated nor built, since that would take most of the time for large messages.
    """
    return {**defaults(message), **fields}


@cache
def defaults(message: type[Message]) -> dict[str, Any]:
    """Return the default values of a message's fields, which callers must not change: they are shared."""
    return {name: _default(field) for name, field in message.model_fields.items()}


def _default(field: FieldInfo) -> Any:
    make: Any = getattr(field.default_factory, "__wrapped__", field.default_factory)
    if make is None:
        return field.default
    return defaults(make) if is_message(make) else make()


Bool = Annotated[bool, Primitive("boolean")]
Byte = Annotated[int, Primitive("byte"), Field(ge=0, le=255)]
String = Annotated[str, Primitive("string")]
Float32 = Annotated[float, Primitive("float")]
Float64 = Annotated[float, Primitive("double")]
Int8 = Annotated[int, Primitive("int8"), Field(ge=-(2**7), le=2**7 - 1)]
UInt8 = Annotated[int, Primitive("uint8"), Field(ge=0, le=2**8 - 1)]
Int16 = Annotated[int, Primitive("int16"), Field(ge=-(2**15), le=2**15 - 1)]
UInt16 = Annotated[int, Primitive("uint16"), Field(ge=0, le=2**16 - 1)]
Int32 = Annotated[int, Primitive("int32"), Field(ge=-(2**31), le=2**31 - 1)]
UInt32 = Annotated[int, Primitive("uint32"), Field(ge=0, le=2**32 - 1)]
Int64 = Annotated[int, Primitive("int64"), Field(ge=-(2**63), le=2**63 - 1)]
UInt64 = Annotated[int, Primitive("uint64"), Field(ge=0, le=2**64 - 1)]
