"""Statistics of experiments: means, intervals, effects, comparisons.

Pure functions over plain numbers. Each formula has its source in its docstring; docs/reference/statistics.md explains
when each one is valid. Distributions come from scipy, which the extra ``experiments`` installs; it is loaded when first
used.
"""

from __future__ import annotations

from hmrsim.experiments.statistics.confidence_sequences import confidence_sequence
from hmrsim.experiments.statistics.effects import (
    Difference,
    Interaction,
    LevelEffect,
    interactions,
    main_effects,
    paired_difference,
    unpaired_difference,
)
from hmrsim.experiments.statistics.intervals import (
    CONFIDENCE,
    MEAN,
    PROPORTION,
    Interval,
    StoppingRule,
    enough,
    mean_interval,
    proportion_interval,
    quantile_interval,
    replications_needed,
)
from hmrsim.experiments.statistics.summaries import Summary, quantile, summary
from hmrsim.experiments.statistics.verdicts import (
    BETTER,
    EQUIVALENT,
    UNDECIDED,
    WORSE,
    Comparison,
    Criterion,
    Verdict,
    compare,
    compare_all,
    holm,
    verdict,
)

__all__ = [
    "BETTER",
    "CONFIDENCE",
    "EQUIVALENT",
    "MEAN",
    "PROPORTION",
    "UNDECIDED",
    "WORSE",
    "Comparison",
    "Criterion",
    "Difference",
    "Interaction",
    "Interval",
    "LevelEffect",
    "StoppingRule",
    "Summary",
    "Verdict",
    "compare",
    "compare_all",
    "confidence_sequence",
    "enough",
    "holm",
    "interactions",
    "main_effects",
    "mean_interval",
    "paired_difference",
    "proportion_interval",
    "quantile",
    "quantile_interval",
    "replications_needed",
    "summary",
    "unpaired_difference",
    "verdict",
]
