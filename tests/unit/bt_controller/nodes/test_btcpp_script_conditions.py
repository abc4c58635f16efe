"""``_skipIf``, ``_onSuccess`` and so on, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

from bt_controller.scripting.parser import parse
from bt_controller.scripting.scripted import ScriptConditions
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

LOGS = {"_onSuccess": "log := 'success'", "_onFailure": "log := 'failure'", "_post": "log = log .. ', done'"}
HALTS = {"_onHalted": "halts += 1"}
SHARED = {"_skipIf": "runs > 2", "_onSuccess": "runs += 1"}
STOP, GO = {"stop": True}, {"go": True}


def when(**scripts):
    return ScriptConditions.bind({attribute: parse(text) for attribute, text in scripts.items()})


@rows(
    {
        "a true _failureIf fails": Row(when(_failureIf="true"), "R", "F", ticks="0"),
        "a true _successIf succeeds": Row(when(_successIf="true"), "R", "S", ticks="0"),
        "a true _skipIf skips": Row(when(_skipIf="true"), "R", "-", ticks="0"),
        "a false condition changes nothing": Row(
            [when(_failureIf="1 > 2"), when(_successIf="1 > 2"), when(_skipIf="1 > 2")], "RS", "RS"
        ),
        "failure comes before success": Row(when(_skipIf="true", _successIf="true", _failureIf="true"), "S", "F"),
        "success comes before skipping": Row(when(_skipIf="true", _successIf="true"), "S", "S", ticks="0"),
        "conditions are looked at when the node is idle only": Row(
            when(_skipIf="stop"), "R", ["R", STOP, "R"], before={"stop": False}, halts="0"
        ),
        "conditions are looked at again after a halt": Row(
            when(_skipIf="stop"), "R", ["R!", STOP, "-"], before={"stop": False}
        ),
        "what has ended is not idle": Row(
            when(_failureIf="stop", _while="!stop"), "S", ["S", STOP, "S"], before={"stop": False}, ticks="2"
        ),
        "while skips what would begin": Row(when(_while="false"), "S", "-", ticks="0"),
        "while halts what runs": Row(
            when(_while="go"), "R", ["R", {"go": False}, "-"], before=GO, ticks="1", halts="1"
        ),
        "while runs the script for halting": Row(
            when(_while="go", **HALTS), "R", ["R", {"go": False}, "-"], before={**GO, "halts": 0}, after={"halts": 1}
        ),
        "while has to be looked at": Row(when(_while="true"), "R", "R", due=1.0),
        "other conditions need no look": Row(when(_skipIf="false"), "R", "R", due=NEVER),
        "scripts follow success": Row(when(**LOGS), "S", "S", after={"log": "success, done"}),
        "scripts follow failure": Row(when(**LOGS), "F", "F", after={"log": "failure, done"}),
        "scripts follow what a condition said": Row(
            when(_failureIf="true", _onFailure="log := 'f'"), "S", "F", after={"log": "f"}
        ),
        "no script follows what runs": Row(when(**LOGS), "R", "R", before={"log": ""}, after={"log": ""}),
        "no script follows what is skipped": Row(when(**LOGS), "-", "-", before={"log": ""}, after={"log": ""}),
        "a script follows a halt": Row(when(**HALTS), "R", "R!", before={"halts": 0}, halts="1", after={"halts": 1}),
        "what has ended is not halted": Row(when(**HALTS), "S", "S!", before={"halts": 0}, after={"halts": 0}),
        "scripts share entries": Row(when(**SHARED), "RS", ["RS!-"], before={"runs": 2}, ticks="2"),
    }
)
def test_conditions_and_scripts(behaves, row):
    behaves(row)
