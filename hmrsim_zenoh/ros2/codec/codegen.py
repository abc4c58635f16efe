"""The source of a function for one type, which `encoders` and `decoders` generate line by line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hmrsim_zenoh.ros2.codec.layout import Run

if TYPE_CHECKING:
    import struct


class Code:
    """Lines of source and the values of the names in them.

    Args:
        at: The offset of the message in the bytes; None if it varies.

    Attributes:
        at: The offset of the next value in the bytes; None if it is known only at run time.
    """

    def __init__(self, names: Mapping[str, Any], at: int | None) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = dict(names)
        self.at = at

    def run(self, codes: Sequence[str], use: Callable[[struct.Struct], Any], line: Callable[[str], str]) -> None:
        """Add a line for a run of numbers, and one that advances the position.

        Args:
            codes: The formats of the numbers.
            use: Returns the method of a struct that the line calls.
            line: Returns the line, given the name of that method.
        """
        run, name = Run(tuple(codes)), f"run{len(self.names)}"
        if self.at is None and run.shifts:
            self.lines += [line(f"{name}[pos & 7]"), f"pos += {name}_size[pos & 7]"]
            self.names[name] = run.each(use)
            self.names[f"{name}_size"] = run.each(lambda packed: packed.size)
            return
        packed = run.packed(self.at or 0)
        self.names[name] = use(packed)
        if self.at is None:
            self.lines += [line(name), f"pos += {packed.size}"]
        else:
            self.at += packed.size
            self.lines += [line(name), f"pos = {self.at}"]
