"""What asking was worth in a sweep: net and gross reward, how often it asked, and information."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sloop_ppl.eval._tables import Cell, Estimate, Table
from sloop_ppl.eval.results import Results, TargetKey, reward_summary
from sloop_ppl.eval.trials import Trial

__all__ = ["question_summary", "question_table", "report_summary"]

_TERCILES = ("worst", "middle", "best")


def report_summary(results: Results) -> dict[str, Any]:
    """Return what ``sloop eval report --json`` prints: rewards, and what asking was worth."""
    asked = {"questions": question_summary(results)} if "asking" in results.manifest else {}
    return {**reward_summary(results), **asked}


def question_summary(results: Results) -> dict[str, Any]:
    """Return model -> number of questions -> what they were worth; empty where none were asked.

    Returns
    -------
    dict
        Of each number: ``n`` trials; ``net``, the mean discounted reward less that without
        questions on the same targets and starts, costs included, with its interval ``ci95``;
        ``gross``, the same without costs; ``asked``, questions a trial; ``reward`` itself;
        ``expected_bits`` and ``realised_bits`` a question; ``terciles``, the net of the targets
        with the worst, middle and best log score. With several costs the first is here, the
        others under ``costs``. Where the sweep has no search without questions, net and gross are
        the reward itself.
    """
    found: dict[str, Any] = {}
    for model in results.models if "asking" in results.manifest else ():
        found[model] = {}
        for count, costs in _settings(results).items():
            first, *others = [_summary(results, model, count, cost) for cost in costs]
            if others:
                first["costs"] = {
                    f"{cost:g}": one for cost, one in zip(costs[1:], others, strict=True)
                }
            found[model][str(count)] = first
    return found


def _settings(results: Results) -> dict[int, tuple[float, ...]]:
    asking = results.manifest["asking"]
    costs = tuple(float(cost) for cost in asking["question_costs"])
    return {int(q): costs if q else (0.0,) for q in asking["questions"]}


def _summary(results: Results, model: str, count: int, cost: float) -> dict[str, Any]:
    trials = _trials(results, model, count, cost)
    before = _means(_trials(results, model, 0, 0.0), "discounted_reward")
    net, gross = (_less(_means(trials, name), before) for name in (
        "discounted_reward", "gross_reward",
    ))  # fmt: skip
    mean = results.estimate(net)
    asked = sum(trial.asked for trial in trials)
    return {
        "n": len(trials),
        "net": mean.mean,
        "ci95": [mean.low, mean.high],
        "se": _standard_error(results, net),
        "gross": float(np.mean(list(gross.values()))),
        "reward": float(np.mean([trial.discounted_reward for trial in trials])),
        "asked": asked / len(trials),
        "expected_bits": sum(t.expected_bits for t in trials) / asked if asked else 0.0,
        "realised_bits": sum(t.realised_bits for t in trials) / asked if asked else 0.0,
        "realised_se": _realised_error(trials, asked),
        "terciles": _terciles(trials, net),
    }


def _trials(results: Results, model: str, count: int, cost: float) -> list[Trial]:
    return [
        trial
        for trial in results.trials
        if (trial.key.model, trial.key.questions, trial.key.question_cost) == (model, count, cost)
    ]


def _means(trials: Sequence[Trial], name: str) -> dict[TargetKey, float]:
    sums: dict[TargetKey, list[float]] = {}
    for trial in trials:
        value = getattr(trial, name)
        key = trial.key.description, trial.key.target
        sums.setdefault(key, []).append(trial.discounted_reward if value is None else value)
    return {key: float(np.mean(values)) for key, values in sums.items()}


def _less(
    one: Mapping[TargetKey, float], other: Mapping[TargetKey, float]
) -> dict[TargetKey, float]:
    return {key: value - other.get(key, 0.0) for key, value in one.items()}


def _standard_error(results: Results, values: Mapping[TargetKey, float]) -> float:
    """Return the standard error of a mean over targets, clustered by configuration."""
    return _clustered(list(values.values()), results.clusters(values))


def _realised_error(trials: Sequence[Trial], asked: int) -> float:
    """Return the standard error of the realised less the expected bits a question."""
    if not asked:
        return 0.0
    clusters = [(trial.map, trial.configuration) for trial in trials]
    gaps = [trial.realised_bits - trial.expected_bits for trial in trials]
    return _clustered(gaps, clusters) * len(trials) / asked


def _clustered(values: Sequence[float], clusters: Sequence[tuple[str, str]]) -> float:
    mean, sums = float(np.mean(values)), dict.fromkeys(clusters, 0.0)
    for value, cluster in zip(values, clusters, strict=True):
        sums[cluster] += value - mean
    k = len(sums)
    spread = sum(total**2 for total in sums.values())
    return float(np.sqrt(spread * k / max(k - 1, 1)) / len(values))


def _terciles(trials: Sequence[Trial], net: Mapping[TargetKey, float]) -> dict[str, float]:
    scores = {(t.key.description, t.key.target): t.log_score or 0.0 for t in trials}
    order = sorted(net, key=lambda key: scores[key])
    parts = np.array_split(np.array([net[key] for key in order]), 3)
    return {
        name: float(part.mean()) for name, part in zip(_TERCILES, parts, strict=True) if len(part)
    }


def question_table(results: Results) -> Table:
    """Return the same as a table of the report."""
    rows: list[tuple[Cell, ...]] = []
    for model, counts in question_summary(results).items():
        for count, one in counts.items():
            costs = results.manifest["asking"]["question_costs"]
            by_cost = {f"{costs[0]:g}": one, **one.get("costs", {})} if int(count) else {"0": one}
            for cost, values in by_cost.items():
                rows.append(
                    (
                        f"{model}, up to {count} at {cost}",
                        Estimate(values["asked"], digits=2),
                        Estimate(values["net"], *values["ci95"]),
                        Estimate(values["gross"]),
                        *(Estimate(values["terciles"].get(name, 0.0)) for name in _TERCILES),
                        Estimate(values["expected_bits"], digits=2),
                        Estimate(values["realised_bits"], digits=2),
                    )
                )
    asking = results.manifest["asking"]
    return Table(
        "questions",
        f"What asking is worth: answerer {asking['answerer']}, questions {asking['choice']}",
        (
            "model, questions at cost",
            "asked",
            "net",
            "gross",
            "net, worst third",
            "middle",
            "best",
            "bits expected",
            "bits realised",
        ),
        tuple(rows),
        (
            (
                "Net and gross: discounted reward with and without the costs of questions, less "
                "that of the same starts without questions. Thirds by log score. Bits a question. "
                "Brackets: 95 % intervals, bootstrapped over configurations."
            ),
        ),
    )
