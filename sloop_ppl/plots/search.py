"""Draw a search over its map."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.plots._axes import new_axes, set_title
from sloop_ppl.plots._belief import check_cells, draw_cells, region_outline
from sloop_ppl.plots._ground import draw_shape
from sloop_ppl.plots._marks import add_legend
from sloop_ppl.plots._palette import ACCENTS, belief_colours
from sloop_ppl.plots._protocols import EpisodeLike
from sloop_ppl.plots._robot import (
    draw_finds,
    draw_path,
    draw_questions,
    draw_targets,
    seen_image,
    sparse_steps,
)
from sloop_ppl.plots.city import draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["along", "outcome", "plot_search", "together"]

Beliefs = Mapping[str, NDArray[np.float64]]


def plot_search(
    episode: EpisodeLike,
    city: CityMap,
    *,
    ax: Axes | None = None,
    beliefs: Beliefs | None = None,
    imagined: Sequence[str] = (),
    labels: bool = True,
    legend: bool = True,
    title: str | None = None,
) -> Axes:
    """Draw the path of a search, what it saw, where it said "found", and where the targets were.

    Parameters
    ----------
    episode
        The search.
    city
        Its map.
    ax
        Axes to draw on; a new pyplot figure when None.
    beliefs
        Belief of each target to lay under the path, such as that at the start, shape (H, W).
    imagined
        Targets whose true place was drawn rather than given.
    labels
        True to name landmarks, targets and some of the steps.
    legend
        True to add a legend.
    title
        Title of the axes; the outcome in words when None.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres, limits at the borders of the cells.

    Raises
    ------
    InputError
        When a belief has another shape than the map.
    """
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    axes = new_axes(ax, height=6.9)
    layer = draw_map(axes, city, labels=labels, muted=True, cells=True)
    if beliefs:
        draw_cells(axes, together(beliefs, city), city.grid, alpha=0.75, zorder=1.8)
    seen = seen_image(episode.views, city.grid.shape)
    draw_cells(axes, seen, city.grid, zorder=1.6, vmin=None)
    border = region_outline(seen[..., 3] > 0, city.grid)
    draw_shape(axes, border, 2.3, edge=ACCENTS["view"], points=0.9)
    handles = draw_path(axes, episode.poses)
    handles += draw_targets(axes, episode.places, episode.found_targets, imagined)
    finds, discs = draw_finds(axes, episode)
    handles += finds
    asked = getattr(episode, "questions", ())
    if asked:
        handles.append(draw_questions(axes, episode.poses, asked))
    sky = ACCENTS["view"]
    handles.append(Patch(facecolor=(*to_rgb(sky), 0.4), edgecolor=sky, lw=0.9, label="seen"))
    if beliefs:
        handles.append(Patch(facecolor=belief_colours()(0.45), label="believed"))
    if labels:
        layer.labels = (*_names(episode, city, imagined), *layer.labels)
    layer.avoid(*discs, points=along(episode.poses, city.grid.cell_m))
    set_title(axes, title or f"{outcome(episode)}{asked_words(asked)}")
    if legend:
        add_legend(axes, handles, layer)
    return axes


def outcome(episode: EpisodeLike) -> str:
    """Say in a line how a search ended."""
    found, total = len(episode.found_targets), len(episode.places)
    steps = len(episode.actions)
    names = _listed(episode.found_targets)
    result = {0: "Found nothing", total: f"Found {names}"}.get(
        found, f"Found {names} but not {_listed(_missing(episode))}"
    )
    return (
        f"{result} in {steps} step{'' if steps == 1 else 's'}, "
        f"discounted return {episode.discounted_return:.0f}".replace("-", "−")
    )


def asked_words(questions: Sequence[Any]) -> str:
    """Return what was answered to the questions of a search, behind a full stop; empty for none."""
    answers = ", ".join(f"“{q.answer}”" if q.answer else "no answer" for q in questions)
    count = len(questions)
    return f". Asked {count} question{'' if count == 1 else 's'}: {answers}" if count else ""


def together(beliefs: Beliefs, city: CityMap) -> NDArray[np.float64]:
    """Return one picture of several beliefs: each scaled to its peak, the greatest of them."""
    scaled = [np.zeros(city.grid.shape)]
    for name, belief in beliefs.items():
        table = check_cells(belief, city, f"The belief of '{name}'")
        # 1e-300: a belief that is zero everywhere stays clear.
        scaled.append(table / max(float(table.max()), 1e-300))
    return np.max(scaled, axis=0)  # type: ignore[no-any-return]


def along(poses: Sequence[Any], step_m: float) -> list[tuple[float, float]]:
    """Return points along a path no further apart than `step_m`, without repeats."""
    points: dict[tuple[float, float], None] = {}
    for (x0, y0, *_), (x1, y1, *_) in itertools.pairwise(poses):
        parts = int(np.hypot(x1 - x0, y1 - y0) / step_m) + 1
        for t in np.linspace(0.0, 1.0, parts + 1):
            # Rounded to a micrometre, so that a pose visited twice is one point.
            points[round(x0 + t * (x1 - x0), 6), round(y0 + t * (y1 - y0), 6)] = None
    return list(points)


def _listed(names: Sequence[str]) -> str:
    """Return names as one says them: "A, B and C"."""
    return " and ".join(", ".join(part) for part in (names[:-1], names[-1:]) if part)


def _missing(episode: EpisodeLike) -> list[str]:
    return [name for name in episode.places if name not in episode.found_targets]


def _names(episode: EpisodeLike, city: CityMap, imagined: Sequence[str]) -> list[Any]:
    """Return labels for the targets and for some steps."""
    from sloop_ppl.plots._labels import Label

    names = []
    for name, place in episode.places.items():
        colour = ACCENTS["truth" if name in episode.found_targets else "wrong"]
        text = f"{name} (imagined)" if name in imagined else name
        names.append(
            Label(text, shapely.Point(*place), colour, 1.06, "bold", must=True, gap_pt=7.0)
        )
    side = city.grid.east_m - city.grid.west_m
    for step in sparse_steps(episode.poses, side):
        point = shapely.Point(*episode.poses[step][:2])
        names.append(Label(str(step), point, ACCENTS["path"], 0.85, "bold", gap_pt=5.0))
    return names
