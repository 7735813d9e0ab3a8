"""What is shown of `sloop eval quality`: tables and a figure, from what it prints as JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from sloop_ppl.eval._report_figures import model_style, panels, plain
from sloop_ppl.eval._tables import Cell, Estimate, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["quality_figure", "quality_section", "quality_tables"]

Payload = Mapping[str, Any]
_WORDS = "by_relation"
_MOST_CITIES = 20  # where each line has a map of its own, a row for each tells nothing
_KNOWN = {
    "mean_log_score", "mean_log_score_mixed", "median_rank", "expected_distance_m", "mapscore",
    "poa_25m", "poa_50m", "poa_100m", "median_error_m",
}  # fmt: skip
"""Metrics with a column of their own."""
_BOOTSTRAP = "Brackets: 95 % intervals, bootstrapped over configurations."
_REGION = (
    "Coverage: how often the smallest region that holds so much of the belief has the target in "
    "it, ties and the last cell taken at random."
)


def quality_tables(payload: Payload) -> list[Table]:
    """Return the tables: scores, differences, calibration, and scores by group.

    Parameters
    ----------
    payload
        What ``sloop eval quality --json`` prints.
    """
    models: Mapping[str, Payload] = payload["models"]
    fitted = ", fitted without the line's city" if payload.get("cv") else ""
    tables = [_scores(models, payload["relations"] + " relations" + fitted), _calibration(models)]
    if payload["paired"]:
        tables.insert(1, _differences(payload))
    if payload.get("sets"):
        tables.insert(1, _sets(payload["sets"]))
    if payload.get("metrics"):
        tables.insert(1, _order_of_search(models, payload["metrics"]))
    for name, title in (
        ("by_relations", "Mean log score by number of relations"),
        ("by_city", "Mean log score by city"),
        (_WORDS, "Mean log score by relation"),
    ):
        if name != "by_city" or len(next(iter(models.values()))[name]) <= _MOST_CITIES:
            tables.append(_groups(models, name, title))
    return [table for table in tables if table.rows]  # no gold, no relations


def quality_section(
    payload: Payload,
) -> list[str | Table | tuple[str, str, Callable[[], Figure]]]:
    """Return the tables and the figure in the order in which they are read."""
    caption = (
        "Left: mean log score with 95 % interval, as it is (filled) and with 1 % of the uniform "
        "belief mixed in (open). Right: how often the 90 % region holds the target, by number of "
        "relations; the line is where a calibrated belief lies"
    )
    scores, *rest = quality_tables(payload)
    return [scores, ("quality", caption, lambda: quality_figure(payload)), *rest]


def quality_figure(payload: Payload) -> Figure:
    """Draw log scores with their intervals, and coverage by number of relations."""
    models: Mapping[str, Payload] = payload["models"]
    names = tuple(models)
    figure, (left, right) = panels(2, width=4.2, height=1.3 + 0.34 * len(names))
    for place, (name, one) in enumerate(models.items()):
        colour = model_style(name, names)["color"]
        for value, ends, shift, filled in (
            (one["mean_log_score"], one["ci95"], -0.13, True),
            (one["mean_log_score_1pct"], one["ci95_1pct"], 0.13, False),
        ):
            left.plot(ends, [place + shift] * 2, color=colour, lw=1.6)
            left.plot(
                [value], [place + shift], "o", ms=5, color=colour,
                markerfacecolor=colour if filled else "white",
            )  # fmt: skip
    left.set_yticks(range(len(names)), names)
    left.set_ylim(len(names) - 0.5, -0.5)
    left.set_xlabel("mean log score (nats)")
    counts = sorted({count for one in models.values() for count in one["by_relations"]} - {"0"})
    for name, one in models.items():
        coverage_90 = [
            100 * one["by_relations"][count]["calibration"]["90"]["coverage"] for count in counts
        ]
        style = model_style(name, names)
        right.plot(range(len(counts)), coverage_90, "o", ms=4, label=name, lw=1.4, **style)
    right.axhline(90, color="#22252b", lw=0.8, zorder=0)
    right.set_xticks(range(len(counts)), [c.replace("3+", "3 or more") for c in counts])
    right.set_xlim(-0.3, len(counts) - 0.7)
    right.set_ylim(0, 102)
    right.set_xlabel("relations said of the target")
    right.set_ylabel("targets in the 90 % region (%)")
    right.legend(frameon=False, fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    for axes in (left, right):
        plain(axes)
    return figure


def _scores(models: Mapping[str, Payload], how: str) -> Table:
    return Table(
        "quality",
        f"Beliefs against the true places, {how}",
        (
            "model", "log score", "with 1 % uniform", "rank", "distance", "mass",
        ),
        tuple(
            (
                name,
                _interval(one["mean_log_score"], one["ci95"]),
                _interval(one["mean_log_score_1pct"], one["ci95_1pct"]),
                one["median_rank"],
                Estimate(one["expected_distance_m"], digits=1),
                Estimate(one["mass_15m"], digits=3),
            )
            for name, one in models.items()
        ),
        (
            (
                f"{next(iter(models.values()))['n']} targets. Mean natural log of the belief at "
                "the true cell, as it is and with 1 % of the uniform belief mixed in; median rank "
                "of that cell; mean distance in metres from the true place; belief within 15 m of "
                f"it. {_BOOTSTRAP}"
            ),
        ),
    )  # fmt: skip


def _order_of_search(models: Mapping[str, Payload], metrics: Sequence[str]) -> Table:
    """Return the table of what a search in order of belief meets; other metrics come last."""
    others = [name for name in metrics if name not in _KNOWN]
    return Table(
        "quality-search",
        "Beliefs as orders of search",
        ("model", "MapScore", "within 25 m", "50 m", "100 m", "error of the mode", *others),
        tuple(
            (
                name,
                Estimate(one["mapscore"], digits=3),
                *(Estimate(one[f"poa_{d}m"], digits=3) for d in (25, 50, 100)),
                Estimate(one["median_error_m"], digits=1),
                *(Estimate(one[other], digits=3) for other in others),
            )
            for name, one in models.items()
        ),
        (
            (
                "MapScore: 1 - 2 r, r the share of the area that is searched before the true cell, "
                "1 at best and 0 at random. Belief within some metres of the true place. Median "
                "distance in metres of the most probable cell."
            ),
        ),
    )


def _sets(sets: Mapping[str, Payload]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for which, payload in sets.items():
        for name, one in payload["models"].items():
            rows.append(
                (
                    which,
                    name,
                    one["n"],
                    _interval(one["mean_log_score_1pct"], one["ci95_1pct"]),
                    Estimate(one["mapscore"], digits=3),
                    Estimate(one["poa_50m"], digits=3),
                    Estimate(one["calibration"]["90"]["coverage"], digits=2),
                )
            )
    return Table(
        "quality-sets",
        "Scores by set of descriptions, with 1 % uniform mixed in",
        ("set", "model", "n", "log score", "MapScore", "50 m", "90 %"),
        tuple(rows),
        (
            (
                "50 m: belief within 50 m of the true place. 90 %: coverage of the region that "
                f"holds 90 % of the belief. {_BOOTSTRAP}"
            ),
        ),
    )


def _differences(payload: Payload) -> Table:
    return Table(
        "quality-differences",
        "Paired differences of the log score",
        ("difference", "log score", "with 1 % uniform"),
        tuple(
            (
                pair,
                _interval(one["mean"], one["ci95"]),
                _interval(mixed["mean"], mixed["ci95"]),
            )
            for (pair, one), mixed in zip(
                payload["paired"].items(), payload["paired_1pct"].values(), strict=True
            )
        ),
        (_BOOTSTRAP,),
    )


def _calibration(models: Mapping[str, Payload]) -> Table:
    counts = sorted({count for one in models.values() for count in one["by_relations"]})
    heads = ["all", *(f"{count} relation{'' if count == '1' else 's'}" for count in counts)]

    def cells(one: Payload, level: str) -> list[Cell]:
        groups = [one, *(one["by_relations"].get(count) for count in counts)]
        calibrations = [group["calibration"][level] if group else None for group in groups]
        return [
            c and f"{c['coverage']:.2f} ({_area(c['area_m2'])})" for c in calibrations
        ]  # fmt: skip

    rows: list[tuple[Cell, ...]] = []
    for level in ("50", "90"):
        rows.append((f"{level} % region", *[None] * len(heads)))
        rows += [(name, *cells(one, level)) for name, one in models.items()]
    return Table(
        "quality-calibration",
        "Coverage of the regions, and their mean area in 1000 m²",
        ("model", *heads),
        tuple(rows),
        (_REGION, "In brackets the mean area in thousands of square metres."),
    )


def _area(area_m2: float) -> str:
    return f"{area_m2 / 1000:.1f}"


def _interval(mean: float, ends: Sequence[float]) -> Estimate:
    low, high = ends
    return Estimate(mean, low, high, digits=2)


def _score(value: float) -> Estimate:
    return Estimate(value, digits=2)


def _groups(models: Mapping[str, Payload], name: str, title: str) -> Table:
    """Return a table of the mean log scores with 1 % mixed in, a row per group."""
    first = next(iter(models.values()))
    return Table(
        f"quality-{name.replace('_', '-')}",
        f"{title}, with 1 % uniform mixed in",
        ("", "n", *models),
        tuple(
            (
                group,
                one["n"],
                *(_score(m[name][group]["mean_log_score_1pct"]) for m in models.values()),
            )
            for group, one in first[name].items()
        ),
        ("A target counts once for each relation that is said of it.",) if name == _WORDS else (),
    )
