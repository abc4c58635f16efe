"""What the results of an experiment say, from its table of runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.documents.yaml_text import read_yaml
from hmrsim.experiments.comparing import SUCCESS
from hmrsim.experiments.report.columns import columns_of
from hmrsim.experiments.report.comparisons import comparisons_of
from hmrsim.experiments.report.effects import effects_of
from hmrsim.experiments.report.model import Experiment, Measure, Summary
from hmrsim.experiments.report.running import running_of
from hmrsim.experiments.report.treatments import endings_of, histograms_of, treatments_of
from hmrsim.experiments.results.repeats import counted, note_of

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Columns
    from hmrsim.experiments.results.store import Results


def summary_of(results: Results) -> Summary:
    """Return what the results say, as they are now; those of an experiment that still runs may be read.

    Raises:
        MissingExtra: scipy is not installed.
    """
    about = results.about
    columns = columns_of(results)
    cells = about["scenarios"] * len(about["treatments"])
    replications = about["replications"]
    most = cells * replications["max"]
    least = cells * replications["min"] if replications["until"] else most
    return Summary(
        experiment=_experiment(about),
        runs=len(columns),
        least=least,
        most=most,
        successes=int(columns.success.sum()),
        notes=tuple(_notes(columns, least)),
        measures={name: Measure(**said) for name, said in _measures(about).items()},
        endings=endings_of(columns),
        treatments=treatments_of(columns),
        comparisons=comparisons_of(columns, about),
        effects=effects_of(columns),
        distributions=histograms_of(columns),
        running=running_of(columns),
        failures=columns.failures,
    )


def _measures(about: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    success = {"value": "", "better": "larger", "margin": None, "relative": False}
    return {SUCCESS: success, **about["measures"]}


def _experiment(about: Mapping[str, Any]) -> Experiment:
    said, _, _ = read_yaml(about["text"])
    return Experiment(
        name=about["name"],
        path=about["path"],
        text=about["text"],
        hash=about["hash"],
        seed=said.get("seed", 0),
        world=str(said["world"]),
        world_hash=about["world"],
        variant=tuple(about["variant"]),
        factors=tuple(about["factors"]),
        scenarios=about["scenarios"],
        replications=about["replications"],
        hmrsim=about["hmrsim"],
        python=about["python"],
        host=about["host"],
    )


def _notes(columns: Columns, least: int) -> Iterator[str]:
    """Yield what is missing."""
    if not len(columns):
        yield "No run has a result yet."
    elif len(columns) < least:
        yield (
            f"{len(columns):,} of {least:,} runs have a result: the experiment still runs, or was stopped; the same "
            "command goes on with it."
        )
    count = counted(len(columns), float(columns.squares.sum()))
    if note := note_of(len(columns), count):
        yield f"{note}."
    for name, count in columns.texts.items():
        yield f"{name} is a text in {count:,} runs, of which there are no means."
    for name, values in columns.measures.items():
        if len(columns) and not (values == values).any() and name not in columns.texts:  # noqa: PLR0124 - NaN
            yield f"{name} has no value in any run."
