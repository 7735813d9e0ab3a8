"""Score frame predictors on the maps of a folder, and word and draw the scores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._annotated_frames import AnnotatedFrames, score_annotated
from sloop_ppl.eval._frame_annotations import read_judgements
from sloop_ppl.eval._frame_descriptions import DescribedFrameScore, score_described_frames
from sloop_ppl.eval._frames import FrameEvaluation, cross_validate_frames
from sloop_ppl.eval.descriptions import read_descriptions
from sloop_ppl.inference._frame_examples import maps_of_folder
from sloop_ppl.inference._frame_training import RECIPES
from sloop_ppl.maps import bundled_maps, load_map
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import RenderableType

__all__ = ["FrameReport", "frame_lines", "score_frames"]


@dataclass(frozen=True)
class FrameReport:
    """How good frame predictors are: on buildings, in what people said, against what they drew.

    Parameters
    ----------
    buildings
        On buildings; without scores where only annotations were given.
    words
        In what people said, if asked for.
    annotated
        Against annotated fronts, if there are any.
    """

    buildings: FrameEvaluation
    words: DescribedFrameScore | None = None
    annotated: AnnotatedFrames | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop eval frames --json`` prints."""
        payload = self.buildings.to_json()
        if self.words is not None:
            payload["descriptions"] = self.words.to_json()
        if self.annotated is not None:
            payload["annotated"] = self.annotated.to_json()
        return payload

    def figure(self) -> Figure:
        """Draw the deviations like the paper's figure; see `plot_deviations`."""
        from sloop_ppl.plots.deviations import draw_deviations

        boxes = {
            name: [s.deviation_deg for s in self.buildings.select(name)]
            for name in self.buildings.predictors
        }
        annotated = {} if self.annotated is None else self.annotated.boxes
        return draw_deviations(boxes, self.buildings.agreement, annotated)


def score_frames(
    maps: str | Path | None = None,
    *,
    recipes: str = "ego-ctx,ctx,ego",
    descriptions: Sequence[str | Path] = (),
    annotations: Sequence[str | Path] = (),
    epochs: int | None = None,
    patience: int | None = None,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> FrameReport:
    """Cross-validate recipes on the maps of a folder.

    Parameters
    ----------
    maps
        Folder of map files; the bundled maps when None, which tell no addresses.
    recipes
        Names in :data:`sloop_ppl.inference._frame_training.RECIPES`, separated by commas.
    descriptions
        Description files on which the shipped ego-ctx meets the nearest street.
    annotations
        Files of annotated frames, against which the shipped predictors and the annotators
        themselves are scored; without `maps` nothing else is.
    epochs, patience
        Epochs and patience instead of the recipes'.
    seed
        Seed of all that is drawn.
    progress
        Called with a line at a time on how it goes.

    Raises
    ------
    UnknownName
        For another recipe.
    InputError
        For an empty or repeated recipe, or files that cannot be used.
    """
    names = [name.strip() for name in recipes.split(",")]
    if "" in names or len(set(names)) < len(names):
        raise InputError(f"Recipes '{recipes}' hold an empty or repeated name; give each once")
    for name in names:
        RECIPES[name]  # an unknown one is refused before the work
    bundled = {name: load_map(name) for name in bundled_maps()} if maps is None else {}
    rng = np.random.default_rng(seed)
    words = None
    if descriptions:
        words = score_described_frames(read_descriptions(descriptions), rng=child(rng, "words"))
    annotated = score_annotated(read_judgements(annotations)) if annotations else None
    if maps is None and annotated is not None:
        return FrameReport(FrameEvaluation((), (), ()), words, annotated)
    found = cross_validate_frames(
        bundled if maps is None else maps_of_folder(maps, progress=progress),
        names,
        epochs=epochs,
        patience=patience,
        rng=child(rng, "folds"),
        progress=progress,
    )
    return FrameReport(found, words, annotated)


def frame_lines(report: FrameReport) -> list[RenderableType]:
    """Return tables of the predictors, for printing."""
    payload = report.to_json()
    overall = {name: {**row, "within45": payload["within45"][name]}
               for name, row in payload["predictors"].items()}  # fmt: skip
    lines: list[RenderableType] = []
    if report.annotated is not None:
        lines.append(
            f"Deviation from the mean of the annotators, {report.annotated.phrases} phrases:"
        )
        lines += [
            f"  {name}: mean {row['mean_deviation_deg']:.1f}°, median "
            f"{row['median_deviation_deg']:.1f}° (n {row['n']})"
            for name, row in payload["annotated"]["predictors"].items()
        ]
    if not payload["folds"]:
        return lines
    lines += [
        f"Mean over the folds {', '.join(payload['folds'])}, each city held out:",
        _table(overall),
        "Disputed: the nearest street is more than 15 degrees off the address:",
        _table(payload["disputed"]),
    ]
    if payload["entrances"]:
        lines += ["Main entrances, never trained on:", _table(payload["entrances"])]
    agreed = payload["address_against_entrance"]
    if agreed["n"]:
        lines.append(
            f"In place of people: address and main entrance of {agreed['n']} buildings are "
            f"{agreed['median_deviation_deg']:.0f} degrees apart (median), within 5 degrees in "
            f"{100 * agreed['within5']:.0f} %."
        )
    if report.words is not None:
        words = report.words
        lines.append(f"Front, behind, left and right of {words.n} targets, log score of the cell:")
        lines += [
            f"  {name}: {mean:.3f} ({words.ci95[name][0]:.2f} to {words.ci95[name][1]:.2f})"
            for name, mean in words.mean_log_score.items()
        ]
        lines += [
            f"  {pair}: {mean:+.3f} ({low:+.2f} to {high:+.2f})"
            for pair, (mean, (low, high)) in words.paired.items()
        ]
    return lines


_COLUMNS = {
    "n": ("n", "{:.0f}"),
    "mean_deviation_deg": ("mean deviation", "{:.1f}°"),
    "median_deviation_deg": ("median", "{:.1f}°"),
    "within45": ("within 45°", "{:.3f}"),
    "mean_log_score": ("log score", "{:.3f}"),
    "arc50": ("in 50 % arc", "{:.3f}"),
    "arc90": ("in 90 % arc", "{:.3f}"),
}


def _table(rows: dict[str, dict[str, float]]) -> RenderableType:
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("predictor")
    for head, _ in _COLUMNS.values():
        table.add_column(head, justify="right")
    for name, row in rows.items():
        table.add_row(name, *(shape.format(row[key]) for key, (_, shape) in _COLUMNS.items()))
    return table
