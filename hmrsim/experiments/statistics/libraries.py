"""scipy and numpy, loaded when they are first needed: they are an extra, and take a third of a second."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.errors import MissingExtra

if TYPE_CHECKING:
    from types import ModuleType

_MESSAGE = "the statistics of experiments need scipy; pip install 'hmrsim[experiments]'"


def distributions() -> Any:
    """Return ``scipy.stats``.

    Raises:
        MissingExtra: It is not installed.
    """
    try:
        from scipy import stats  # noqa: PLC0415 - an extra
    except ImportError:
        raise MissingExtra(_MESSAGE) from None
    return stats


def root_finder() -> Any:
    """Return ``scipy.optimize.brentq``.

    Raises:
        MissingExtra: It is not installed.
    """
    try:
        from scipy.optimize import brentq  # noqa: PLC0415 - an extra
    except ImportError:
        raise MissingExtra(_MESSAGE) from None
    return brentq


def log_normal_probability() -> Any:
    """Return ``scipy.special.log_ndtr``, the logarithm of the normal distribution function.

    Raises:
        MissingExtra: It is not installed.
    """
    try:
        from scipy.special import log_ndtr  # noqa: PLC0415 - an extra
    except ImportError:
        raise MissingExtra(_MESSAGE) from None
    return log_ndtr


def arrays() -> ModuleType:
    """Return ``numpy``.

    Raises:
        MissingExtra: It is not installed.
    """
    try:
        import numpy as np  # noqa: PLC0415 - an extra
    except ImportError:
        raise MissingExtra(_MESSAGE) from None
    return np
