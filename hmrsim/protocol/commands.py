"""What a simulation can be told from outside: the commands that `Simulator.submit` takes."""

from hmrsim.protocol.gateway import (
    CallService,
    CancelGoal,
    Command,
    ForgetResult,
    GetResult,
    Read,
    SendGoal,
    Stop,
    Withdraw,
)

__all__ = [
    "CallService",
    "CancelGoal",
    "Command",
    "ForgetResult",
    "GetResult",
    "Read",
    "SendGoal",
    "Stop",
    "Withdraw",
]
