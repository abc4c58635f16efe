"""The source of a function for one type, line by line, as `encoders` and `decoders` write it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim_zenoh.ros2.codec.layout import Run

if TYPE_CHECKING:
    import struct
    from collections.abc import Callable, Mapping, Sequence


class Code:
    """Lines, and what the names in them stand for.

    Args:
        names: Those that are known at first.
        at: Where the message begins in the bytes; None if here and there.

    Attributes:
        lines: What was written.
        names: What the names stand for.
        at: Where in the bytes the next value is; None if that is known only when the function runs.
    """

    def __init__(self, names: Mapping[str, Any], at: int | None) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = dict(names)
        self.at = at

    def run(self, codes: Sequence[str], use: Callable[[struct.Struct], Any], line: Callable[[str], str]) -> None:
        """Write a line for a run of numbers, and one that goes on behind them.

        Args:
            codes: The numbers' formats.
            use: What of a struct is called.
            line: Makes the line of what is called there.
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
