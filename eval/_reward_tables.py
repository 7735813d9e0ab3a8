"""Tables of rewards: over all trials, by range, completed searches, comparisons, several sweeps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._significance import holm, sign_flip_p
from sloop_ppl.eval._tables import Cell, Estimate, Table
from sloop_ppl.eval.results import Results
from sloop_ppl.rng import child

__all__ = [
    "comparison_table",
    "completed_table",
    "overview_table",
    "reward_table",
    "sweeps_table",
]

STEPS = (10, 25, 50, 100, 200)
_BOOTSTRAP = "Brackets: 95 % intervals, bootstrapped over configurations."


def overview_table(results: Results) -> Table:
    """Return mean reward, share found and steps of each model at each range."""
    rows: list[tuple[Cell, ...]] = []
    for range_cells in results.ranges:
        rows.append((f"range {range_cells:g}", *[None] * 3))
        for model in results.models:
            trials = results.of(model, range_cells)
            rows.append(
                (
                    model,
                    results.estimate(results.rewards(model, range_cells)),
                    Estimate(float(np.mean([t.found for t in trials])), digits=2),
                    Estimate(float(np.mean([t.steps for t in trials])), digits=1),
                )
            )
    n = len(results.of(results.models[0], results.ranges[0]))
    return Table(
        "overview",
        f"All models ({results.label})",
        ("model", "discounted reward", "found", "steps"),
        tuple(rows),
        (f"{n} trials in each cell. {_BOOTSTRAP} Steps are means over all trials.",),
    )


def completed_table(results: Results) -> Table:
    """Return the number of searches that found their target within so many steps."""
    rows: list[tuple[Cell, ...]] = []
    for range_cells in results.ranges:
        rows.append((f"range {range_cells:g}", *[None] * len(STEPS)))
        for model in results.models:
            took = [t.steps for t in results.of(model, range_cells) if t.found]
            rows.append((model, *(sum(s <= most for s in took) for most in STEPS)))
    n = len(results.of(results.models[0], results.ranges[0]))
    return Table(
        "completed",
        "Completed searches by number of steps",
        ("model", *(f"within {most}" for most in STEPS)),
        tuple(rows),
        (f"Of {n} trials for each model and range.",),
    )


def reward_table(results: Results) -> Table:
    """Return rewards over all trials and over completed ones."""
    rows: list[tuple[Cell, ...]] = []
    for range_cells in results.ranges:
        rows.append((f"range {range_cells:g}", *[None] * 4))
        for model in results.models:
            trials = results.of(model, range_cells)
            done = [t for t in trials if t.found]
            rows.append(
                (
                    model,
                    len(trials),
                    results.estimate_trials(trials),
                    len(done),
                    results.estimate_trials(done) if done else None,
                )
            )
    return Table(
        "rewards",
        "Discounted reward over all trials and over completed ones",
        ("model", "trials", "reward", "completed", "reward of these"),
        tuple(rows),
        (
            (
                "The published code kept only the completed trials; a search that never ends then "
                f"costs nothing. {_BOOTSTRAP}"
            ),
        ),
    )


def comparison_table(results: Results) -> Table:
    """Return the paired differences, with sign-flip tests by configuration.

    The primary comparison was named before the run and needs no correction; the model it is
    about against every other at every range are corrected together.
    """
    first, second, range_cells = results.primary
    rng = child(np.random.default_rng(results.seed), "sign flips")
    family = [
        (other, r)
        for r in results.ranges
        for other in results.models
        if other != first and (other, r) != (second, range_cells)
    ]

    def p_of(other: str, r: float) -> float:
        differences = results.difference(first, other, r)
        return sign_flip_p(
            list(differences.values()),
            results.clusters(differences),
            rng=child(rng, other, f"{r:g}"),
        )

    def row(name: str, other: str, r: float) -> tuple[Cell, ...]:
        return name, f"{r:g}", results.estimate(results.difference(first, other, r))

    raw = [p_of(other, r) for other, r in family]
    rows: list[tuple[Cell, ...]] = [
        (
            *row(f"primary: {first} − {second}", second, range_cells),
            _p(p_of(second, range_cells)),
            None,
        )
    ]
    rows += [
        (*row(f"{first} − {other}", other, r), _p(p), _p(corrected))
        for (other, r), p, corrected in zip(family, raw, holm(raw), strict=True)
    ]
    return Table(
        "comparisons",
        "Paired differences of discounted reward on the same targets and starts",
        ("difference", "range", "reward", "p", "p, Holm"),
        tuple(rows),
        (
            (
                f"{_BOOTSTRAP} p: two-sided sign-flip test, configurations flipped whole. The "
                "primary comparison was written into the manifest before the run; the others are "
                "corrected together by Holm's method."
            ),
        ),
    )


def sweeps_table(sweeps: Sequence[Results]) -> Table:
    """Return the rewards of several sweeps on the same descriptions: beliefs by planners.

    Raises
    ------
    InputError
        When they are of different descriptions or maps.
    """
    main = sweeps[0]
    first, second, range_cells = main.primary
    for other in sweeps[1:]:
        for what in ("descriptions", "maps"):
            if other.manifest[what] != main.manifest[what]:
                raise InputError(
                    f"The sweeps in '{main.folder.path}' and '{other.folder.path}' are of "
                    f"different {what}; expected sweeps of the same ones"
                )
    models = list(dict.fromkeys(model for sweep in sweeps for model in sweep.models))
    rows: list[tuple[Cell, ...]] = []
    for sweep in sweeps:
        cells: list[Cell] = [sweep.label]
        for model in models:
            rewards = sweep.rewards(model, range_cells)
            cells.append(sweep.estimate(rewards) if rewards else None)
        if first != second:
            both = {first, second} <= set(sweep.models) and range_cells in sweep.ranges
            gap = sweep.difference(first, second, range_cells) if both else None
            cells.append(None if gap is None else sweep.estimate(gap))
        rows.append(tuple(cells))
    return Table(
        "sweeps",
        f"Discounted reward by planner and belief, range {range_cells:g}",
        (
            "planner; relations; starts",
            *models,
            *([f"{first} − {second}"] if first != second else []),
        ),
        tuple(rows),
        (
            (
                f"{_BOOTSTRAP} `fast` with the published rollout is POUCT in machine code: the "
                "same algorithm, with other random numbers."
            ),
        ),
    )


def _p(p: float) -> str:
    return f"{p:.4f}" if p >= 1e-4 else "< .0001"
