"""The codec agrees with rosbags, Foxglove's codec and a decoder that reads value by value, for every type."""

from __future__ import annotations

import json
import random
import re
import struct
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from mcap.records import Schema
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from hmrsim_zenoh.ros2.codec.decoder import decoder
from hmrsim_zenoh.ros2.codec.encoder import encoder
from hmrsim_zenoh.ros2.codec.structures import PADDING, Field, Kind, Structure, definition
from hmrsim_zenoh.ros2.codec.types import DISTROS
from tests import ros_cdr
from tests.cases import case
from tests.profiles import examples
from tests.ros_types import messages, structures

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

RANGES: Final = {
    "int8": (-(2**7), 2**7 - 1),
    "uint8": (0, 2**8 - 1),
    "byte": (0, 2**8 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint64": (0, 2**64 - 1),
}
THEIRS: Final = {"boolean": "bool", "float": "float32", "double": "float64", "byte": "uint8"}
"""The primitives with another name in rosbags."""

SENT: Final = re.compile(r".*/msg/.*|.*_(Request|Response|FeedbackMessage)")

a_few = settings(examples(3), phases=(Phase.explicit, Phase.reuse, Phase.generate))  # a seed is not made smaller
seeds = st.integers(0, 2**32 - 1)


@cache
def sent_types() -> dict[str, Structure]:
    """Return all sent types by name and distribution; types equal to kilted's are listed once."""
    return {
        f"{name} {distro}": described
        for distro in DISTROS
        for name, described in structures(distro).items()
        if SENT.fullmatch(name) and (distro == "kilted" or described is not structures("kilted").get(name))
    }


def each_type(seed: int) -> Iterator[tuple[str, Structure]]:
    """Yield each sent type, with a seed for it."""
    for name, described in sent_types().items():
        yield f"{name} {seed}", described


class Values:
    """Random values of types, with all fields under the type's own names."""

    def __init__(self, seed: str) -> None:
        self._random = random.Random(seed)
        # Lists that all have items make the larger types larger than a test has time for.
        self._most = self._random.choice((0, 1, 3))

    def of(self, described: Structure) -> dict[str, Any]:
        """Return random values of a type."""
        return {field.name: self._field(field) for field in described.fields if field is not PADDING}

    def _field(self, field: Field) -> Any:
        if field.kind is Kind.SINGLE:
            return self._single(field)
        most = min(self._most, field.capacity) if field.kind is Kind.BOUNDED else self._most
        count = field.capacity if field.kind is Kind.ARRAY else self._random.randint(0, most)
        return [self._single(field) for _ in range(count)]

    def _single(self, field: Field) -> Any:
        if field.nested is not None:
            return self.of(field.nested)
        if field.primitive == "string":
            return "".join(self._random.choices("aZ_/ 0ü✗\U0001f916", k=self._random.randint(0, 9)))
        if field.primitive == "boolean":
            return self._random.random() < 0.5
        if field.primitive in RANGES:
            return self._random.choice((*RANGES[field.primitive], self._random.randint(*RANGES[field.primitive])))
        number = self._random.choice((0.0, -1.5, self._random.uniform(-1e6, 1e6)))
        return struct.unpack("f", struct.pack("f", number))[0] if field.primitive == "float" else number


@cache
def as_it_is(described: Structure) -> Structure:
    """Return a type whose values have the type's own names, not those of our messages."""
    fields = tuple(
        one
        if one is PADDING
        else replace(one, path=(one.name,), nested=None if one.nested is None else as_it_is(one.nested))
        for one in described.fields
    )
    return described if fields == described.fields else Structure(described.name, fields)


@cache
def rosbags_store() -> Any:
    """Return a type store of rosbags that knows all types."""
    store, found = get_typestore(Stores.EMPTY), {}
    for distro in DISTROS:
        for described in structures(distro).values():
            fields = [(field.name, _description(field)) for field in described.fields]
            found[their_name(described)] = ([], fields)
    store.register(found)
    return store


@cache
def their_name(described: Structure) -> str:
    """Return a name for rosbags, where types of two distributions may not share one."""
    package, _, name = described.name.split("/")
    return f"{package}/msg/{name}_{described.hash()[-8:]}"


def _description(field: Field) -> Any:
    if field.nested is not None:
        item: Any = (Nodetype.NAME, their_name(field.nested))
    else:
        item = (Nodetype.BASE, (THEIRS.get(field.primitive, field.primitive), 0))
    if field.kind is Kind.SINGLE:
        return item
    return (Nodetype.ARRAY if field.kind is Kind.ARRAY else Nodetype.SEQUENCE, (item, field.capacity))


def outcome(read: Callable[..., dict[str, Any]], *args: object) -> str:
    """Return the result of decoding: the values as text, as NaN does not equal itself."""
    try:
        return json.dumps(read(*args), sort_keys=True)
    except ValueError:
        return "refused"


def as_theirs(store: Any, described: Structure, values: dict[str, Any]) -> Any:
    """Return a message of rosbags."""
    fields = {field.name: _as_their_field(store, field, values.get(field.name, 0)) for field in described.fields}
    return store.types[their_name(described)](**fields)


def _as_their_field(store: Any, field: Field, value: Any) -> Any:
    if field.nested is not None:
        one = field.kind is Kind.SINGLE
        items = [as_theirs(store, field.nested, item) for item in ([value] if one else value)]
        return items[0] if one else items
    if field.kind is Kind.SINGLE or field.primitive == "string":
        return value
    return np.array(value, THEIRS.get(field.primitive, field.primitive))


@a_few
@given(seeds)
def test_rosbags_writes_the_same(seed: int) -> None:
    """Encoded messages have the bytes that rosbags writes."""
    for own, described in each_type(seed):
        with case(own):
            values = Values(own).of(described)
            store, name = rosbags_store(), their_name(described)
            expected = bytes(store.serialize_cdr(as_theirs(store, described, values), name))
            written = encoder(as_it_is(described))(values)

            assert expected.removeprefix(written).strip(b"\0") == b""
            assert len(expected) - len(written) < 4


@a_few
@given(seeds)
def test_foxglove_writes_and_reads_the_same(seed: int) -> None:
    """The codec for MCAP files, which knows types by their definitions, writes the same bytes and reads the values."""
    reason = "Foxglove's codec, mcap-ros2-support, is not installed"
    writer = pytest.importorskip("mcap_ros2.writer", reason=reason)
    factory = pytest.importorskip("mcap_ros2.decoder", reason=reason).DecoderFactory()
    for number, (own, described) in enumerate(each_type(seed)):
        with case(own):
            values = Values(own).of(described)
            name, text = for_foxglove(described.name), for_foxglove(definition(described))
            written = writer.serialize_dynamic(name, text)[name](values)

            assert written == encoder(as_it_is(described))(values)
            assert values == plain(factory.decoder_for("cdr", Schema(number, text.encode(), "ros2msg", name))(written))


def for_foxglove(text: str) -> str:
    """Return names of types without underscores, which Foxglove's codec rejects."""
    return re.sub(r"/\w+", lambda name: name[0].replace("_", ""), text)


def plain(value: Any) -> Any:
    """Return a value that Foxglove's codec has read as plain values."""
    if isinstance(value, (bytes, list)):
        return [plain(item) for item in value]
    if not hasattr(value, "__slots__"):
        return value
    return {name: plain(getattr(value, name)) for name in value.__slots__ if not name.startswith("_")}


@a_few
@given(seeds)
def test_reads_the_values_of_other_distributions(seed: int) -> None:
    """The decoder reads what other distributions send, and the encoder writes it again."""
    for own, described in each_type(seed):
        with case(own):
            sent = encoder(as_it_is(described))(Values(own).of(described))
            read = decoder(described)(sent)

            assert ros_cdr.read(described, sent) == read
            assert read == decoder(described)(encoder(described)(read))


@a_few
@given(seeds)
def test_other_order_reads_the_same(seed: int) -> None:
    """Big-endian messages decode to the same values."""
    for own, described in each_type(seed):
        with case(own):
            values = Values(own).of(described)
            store, name = rosbags_store(), their_name(described)
            sent = bytes(store.serialize_cdr(as_theirs(store, described, values), name, little_endian=False))

            assert values == decoder(as_it_is(described))(sent)


@a_few
@given(seeds)
def test_broken_bytes_are_read_or_refused(seed: int) -> None:
    """Both decoders agree on changed, truncated and random bytes."""
    for own, described in each_type(seed):
        with case(own):
            chance = random.Random(own)
            sent = bytearray(encoder(as_it_is(described))(Values(own).of(described)))
            for _ in range(chance.randint(1, 4)):
                sent[chance.randrange(4, len(sent))] = chance.randrange(256)
            cut = sent[: chance.randrange(4, len(sent))]
            made_up = b"\0\1\0\0" + chance.randbytes(chance.randrange(99))

            for broken in map(bytes, (sent, cut, made_up)):
                assert outcome(ros_cdr.read, described, broken) == outcome(decoder(described), broken)


@a_few
@given(seeds)
def test_every_value_of_a_byte_is_read_or_refused_by_both_decoders(seed: int) -> None:
    """Both decoders agree on all values of any byte of any type."""
    chance = random.Random(seed)
    own, described = chance.choice(list(each_type(seed)))
    with case(own):
        sent = bytearray(encoder(as_it_is(described))(Values(own).of(described)))
        for at in chance.sample(range(4, len(sent)), min(4, len(sent) - 4)):
            for value in range(256):
                changed = bytes((*sent[:at], value, *sent[at + 1 :]))
                assert outcome(ros_cdr.read, described, changed) == outcome(decoder(described), changed)


@pytest.mark.parametrize(
    ("distro", "name"),
    [
        ("kilted", "nav2_msgs/action/Spin_Goal"),
        ("lyrical", "simulation_interfaces/srv/SetEntityState_Request"),  # our message has no such field
    ],
)
def test_a_boolean_is_one_or_zero(distro: str, name: str) -> None:
    """Both decoders reject any other byte, as Fast-CDR does, even in a field that our message lacks."""
    described = structures(distro)[name]
    sent = encoder(as_it_is(described))(Values("500").of(described))
    for value in range(256):
        changed = sent[:-1] + bytes((value,))
        read = [outcome(ros_cdr.read, described, changed), outcome(decoder(described), changed)]

        assert [value > 1] * 2 == ["refused" == one for one in read], value


@pytest.mark.parametrize("distro", DISTROS)
def test_default_message_is_what_is_read(distro: str) -> None:
    """A model validates a decoded message to the sent one, as far as the distribution has its fields."""
    for name, cls in messages().items():
        described = structures(distro).get(name)
        if described is not None:
            assert cls() == cls.model_validate(decoder(described)(encoder(described)(cls()))), name
