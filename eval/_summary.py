"""The first section of a report: what came out, in a few lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sloop_ppl.eval._reward_tables import comparison_table
from sloop_ppl.eval._tables import Estimate, literal
from sloop_ppl.eval.results import Results

__all__ = ["in_short"]

_BOUNDS = (
    "`informed` is given a Gaussian around the true place and `uniform` nothing: read the other "
    "models between these two."
)


def in_short(results: Results, quality: Mapping[str, Any] | None = None) -> str:
    """Return scores and rewards from the best model to the worst, and the primary comparison.

    Parameters
    ----------
    quality
        What ``sloop eval quality --json`` printed; None leaves the scores out.
    """
    lines = [] if quality is None else [_scores(quality["models"])]
    lines.append(_rewards(results))
    first, second, range_cells = results.primary
    if first != second:
        reward, p = comparison_table(results).rows[0][2:4]
        assert isinstance(reward, Estimate)
        p_text = f"p {p}" if str(p).startswith("<") else f"p = {p}"
        lines.append(
            f"The primary comparison, named before the run: `{first}` − `{second}` at range "
            f"{range_cells:g} is {reward.text()} of discounted reward, {p_text}."
        )
    if {"informed", "uniform"} <= set(results.models):
        lines.append(_BOUNDS)
    return "\n".join(f"- {literal(line)}" for line in lines)


def _scores(models: Mapping[str, Mapping[str, Any]]) -> str:
    estimates = {}
    for name, one in models.items():
        low, high = one["ci95_1pct"]
        estimates[name] = Estimate(one["mean_log_score_1pct"], low, high, digits=2)
    return (
        "Beliefs, by mean log score of the true cell with 1 % of the uniform belief mixed in: "
        f"{_ranked(estimates)}."
    )


def _rewards(results: Results) -> str:
    range_cells = results.primary[2]
    estimates = {
        model: results.estimate(results.rewards(model, range_cells)) for model in results.models
    }
    return f"Searches, by mean discounted reward at range {range_cells:g}: {_ranked(estimates)}."


def _ranked(estimates: Mapping[str, Estimate]) -> str:
    best_first = sorted(estimates, key=lambda name: -estimates[name].mean)
    return ", ".join(f"`{name}` {estimates[name].text()}" for name in best_first)
