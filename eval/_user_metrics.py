"""Load a metric of one's own from a Python file."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.eval.descriptions import Place
from sloop_ppl.eval.metrics import METRICS, Metric, json_names
from sloop_ppl.maps import Grid
from sloop_ppl.user_file import UserValue, failing, load_from_file, needed_arguments

__all__ = ["metrics_with"]

_WANTED = "a metric: a function f(belief, grid, truth) that returns a number"

_TAKEN = (
    "n", "ci95", "mass_15m", "hpd90_coverage", "mean_log_score_1pct", "ci95_1pct", "calibration",
    "by_relations", "by_relation", "by_city",
)  # fmt: skip
"""Keys of what is printed of a model that are no metric."""


def metrics_with(specs: Iterable[str]) -> dict[str, Metric]:
    """Return the registered metrics, and those of some files under their own names.

    Parameters
    ----------
    specs
        ``FILE.py:NAME`` each; the metric is called NAME.

    Raises
    ------
    UnknownName
        When a file has nothing of that name.
    InputError
        When a file does not exist or fails, what it holds is no metric, or its name is taken.
    """
    found = dict(METRICS)
    for spec in specs:
        held = load_from_file(spec, "Metric", _WANTED, _measures)
        name = held.label.rpartition(":")[2]
        if name in (*found, *json_names(found).values(), *_TAKEN):
            raise InputError(
                f"Metric '{held.label}' has a name that is taken ('{name}'); expected another than "
                f"{', '.join((*found, *_TAKEN))}"
            )
        takes = needed_arguments(held.value)
        if len(takes) != 3:
            raise InputError(
                f"Metric '{held.label}' takes {', '.join(takes) or 'nothing'}; expected three "
                "arguments: belief, grid, truth"
            )
        found[name] = _guarded(held)
    return found


def _measures(value: Any) -> bool:
    if inspect.isclass(value):
        return "__call__" in vars(value)
    return callable(value) and bool(needed_arguments(value))


def _guarded(held: UserValue) -> Metric:
    """Return a metric that says in one line what fails, or is no number."""

    def measure(belief: NDArray[np.float64], grid: Grid, truth: Place) -> float:
        with failing("Metric", held.label, held.path):
            value = held.value(belief, grid, truth)
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            raise InputError(f"Metric '{held.label}' returns {value!r}; expected a finite number")
        return number

    return measure
