"""One run whose controller is a command: any program, over Zenoh, with an endpoint of its own."""

from __future__ import annotations

import math
import shlex
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hmrsim.errors import HmrsimError
from hmrsim.experiments.judging.endings import Judge
from hmrsim.experiments.judging.labels import ERROR, TIMEOUT
from hmrsim.experiments.judging.measures import needs_report
from hmrsim.experiments.results.row import Row
from hmrsim.experiments.running.controllers import parameters_of
from hmrsim.experiments.running.processes import ControllerProcess, follow
from hmrsim.experiments.running.single import needs_trace, result_of, unwatched, with_report, with_trace
from hmrsim.report.live import LiveReport
from hmrsim.settings.run import RunSettings
from hmrsim.trace.late import LateTrace
from hmrsim.world.overlays.expressions import substituted
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from hmrsim.experiments.file.model import Controller
    from hmrsim.experiments.file.plan import Plan, Run
    from hmrsim.experiments.running.single import Watchers
    from hmrsim.protocol.sinks import Sink


def run_command(plan: Plan, run: Run, further: Watchers = unwatched) -> Row:
    """Return the result of a run whose controller is a command.

    It is started in the folder of the experiment with ``HMRSIM_CONNECT``, ``HMRSIM_SEED`` and ``HMRSIM_RUN`` in its
    environment, in a process group of its own, which is killed when the run has ended. Exit code 0 is a success, 1 a
    failure, and all others a crash. *further* makes further sinks, such as one that records the run.
    """
    began = time.monotonic()
    treatment = plan.treatments[run.treatment]
    try:
        loaded = plan.world(run.scenario, run.treatment)
        words = words_of(treatment, plan.names(run.scenario))
    except (HmrsimError, ValueError) as error:
        return Row(run, ERROR, str(error), wall=time.monotonic() - began)
    # Its limits end a run whose controller does not ask to advance.
    settings = RunSettings(
        seed=run.seed, duration=plan.file.limits.simulated, clock="lockstep", participant_timeout=math.inf
    )
    judge, trace = Judge(plan.file.ends), LateTrace(loaded.world, settings)
    report = LiveReport(loaded.world, settings) if needs_report(plan.file) else None
    sinks: list[Sink] = [trace, judge] if needs_trace(plan) else [judge]
    watchers = with_report(report, further)
    options = SessionOptions(listen=("tcp/127.0.0.1:0",))
    with Host(loaded, options, settings, sinks=sinks, watchers=watchers) as host:
        judge.watch(host.simulator, host.end)
        host.start()
        try:
            controller = ControllerProcess(words, plan.path.parent, _variables(plan, run, host.endpoints[0]))
        except OSError as error:
            return Row(run, ERROR, f"{words[0]}: {error.strerror or error}", wall=time.monotonic() - began)
        with controller:
            ending, cause = follow(controller, host)
        over = host.pacing.over
        host.stop()
        # Nothing runs any more: what the simulator knows can be read.
        if ending in {"succeeded", "failed"} and not judge.label and not over:
            judge.controller_ended(succeeded=ending == "succeeded", now=host.simulator.now)
        judged = bool(judge.label)
        judge.end(TIMEOUT if ending in {"succeeded", "failed"} else ending, host.simulator.now)
        values = (lambda: report.report(host.simulator).model_dump(mode="json")) if report else dict
        row = with_trace(plan, result_of(plan, run, judge, host.simulator, values), trace, host.simulator)
    return replace(
        row,
        cause="; ".join(filter(None, [row.cause] if judged else [cause, row.cause])),
        wall=time.monotonic() - began,
        output=controller.output,
    )


def words_of(treatment: Controller, names: Mapping[str, Any]) -> list[str]:
    """Return the command of a treatment, with the values of names in it.

    Raises:
        ValueError: It is empty, or an expression has no value.
    """
    command = treatment.command
    parts = shlex.split(command) if isinstance(command, str) else list(command or ())
    known = {**names, **parameters_of(treatment, names)}
    words = [str(substituted(part, known)) for part in parts]
    if not words:
        raise ValueError("the command is empty")
    return words


def _variables(plan: Plan, run: Run, endpoint: str) -> dict[str, str]:
    parameters = parameters_of(plan.treatments[run.treatment], plan.names(run.scenario))
    values = {key: str(value) for key, value in parameters.items()}
    return values | {"HMRSIM_CONNECT": endpoint, "HMRSIM_SEED": str(run.seed), "HMRSIM_RUN": str(run.number)}
