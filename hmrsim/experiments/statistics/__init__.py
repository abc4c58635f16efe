"""What an experiment allows one to claim: means, intervals, effects, comparisons.

Pure functions over plain numbers. Each formula has its source in its docstring, which says when it is
valid. Distributions are those of scipy, which the extra ``experiments`` installs and which is loaded when first
used.
"""

from __future__ import annotations

from hmrsim.experiments.statistics.corrections import holm
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
    Interval,
    mean_interval,
    proportion_interval,
    quantile_interval,
)
from hmrsim.experiments.statistics.stopping import MEAN, PROPORTION, StoppingRule, enough, replications_needed
from hmrsim.experiments.statistics.summary import Summary, quantile, summary

__all__ = [
    "CONFIDENCE",
    "MEAN",
    "PROPORTION",
    "Difference",
    "Interaction",
    "Interval",
    "LevelEffect",
    "StoppingRule",
    "Summary",
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
]
