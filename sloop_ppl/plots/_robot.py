"""Draw what a search did: the path, the views, the finds and the targets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.plots._axes import stroke
from sloop_ppl.plots._palette import ACCENTS, INK, PAPER
from sloop_ppl.plots._protocols import EpisodeLike

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.path import Path

__all__ = [
    "draw_finds",
    "draw_path",
    "draw_questions",
    "draw_targets",
    "is_find",
    "robot_path",
    "seen_image",
    "sparse_steps",
    "target_style",
]

_TICK = [(-0.55, 0.0), (-0.15, -0.42), (0.6, 0.45)]
_CROSS = [(-0.45, -0.45), (0.45, 0.45), (-0.45, 0.45), (0.45, -0.45)]


def is_find(action: str) -> bool:
    """Tell whether an action declares targets found, rather than moving."""
    return str(action).startswith("find")


def robot_path(heading_rad: float) -> Path:
    """Return the robot's marker, an arrow head that points where it faces."""
    from matplotlib.path import Path

    corners = np.array([(1.0, 0.0), (-0.75, 0.68), (-0.38, 0.0), (-0.75, -0.68), (1.0, 0.0)])
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return Path(corners @ np.array([[c, s], [-s, c]]), closed=True)


def sparse_steps(poses: Sequence[Any], side_m: float, most: int = 14) -> list[int]:
    """Return the steps to number: few, and none where an earlier one stands close by."""
    every = max(1, math.ceil(len(poses) / most))
    # Numbers of steps that people count in.
    rounded = next(n for n in (1, 2, 5, 10, 20, 25, 50, 100, every) if n >= every)
    chosen: list[int] = []
    for i in range(rounded, len(poses), rounded):
        x, y = poses[i][:2]
        # 2 % of the side is about the height of a number.
        if all(math.hypot(x - poses[j][0], y - poses[j][1]) > 0.02 * side_m for j in chosen):
            chosen.append(i)
    return chosen


def seen_image(views: Any, shape: tuple[int, int], alpha: float = 0.17) -> NDArray[np.float64]:
    """Return an RGBA image of the cells that were in view, denser where they were seen more often.

    Parameters
    ----------
    views
        True on the cells in view, shape (steps, H, W).
    alpha
        Opacity of a cell seen once, in [0, 1].
    """
    from matplotlib.colors import to_rgb

    counts = np.asarray(views, dtype=float).reshape(-1, *shape).sum(axis=0)
    image = np.zeros((*shape, 4))
    image[..., :3] = to_rgb(ACCENTS["view"])
    # Layers of opacity a laid over one another leave (1 - a) ** n clear; five looks tell enough.
    image[..., 3] = np.minimum(1.0 - (1.0 - alpha) ** np.minimum(counts, 5.0), 0.55)
    return image


def draw_path(ax: Axes, poses: Sequence[Any]) -> list[Any]:
    """Draw the way from the start to the end, a small arrow at each pose; return legend handles."""
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import withStroke

    k, colour = stroke(ax), ACCENTS["path"]
    x = [float(p[0]) for p in poses]
    y = [float(p[1]) for p in poses]
    halo = [withStroke(linewidth=3.0 * k, foreground=PAPER, alpha=0.85)]
    ax.add_line(Line2D(x, y, color=colour, lw=1.5 * k, path_effects=halo, zorder=4.0))
    distinct = dict.fromkeys((float(p[0]), float(p[1]), float(p[2]) % math.tau) for p in poses)
    for px, py, heading in distinct:
        mark = robot_path(heading)
        ax.add_line(
            Line2D(
                [px], [py], ls="none", marker=mark, ms=8.0 * k, mfc=colour, mec=PAPER,
                mew=0.5 * k, zorder=4.1,
            )
        )  # fmt: skip
    start = Line2D(
        [x[0]], [y[0]], ls="none", marker="o", ms=7.5 * k, mfc=PAPER, mec=colour, mew=1.8 * k,
        zorder=4.4, label="start",
    )  # fmt: skip
    end = Line2D(
        [x[-1]], [y[-1]], ls="none", marker=robot_path(float(poses[-1][2])), ms=16.0 * k,
        mfc=colour, mec=PAPER, mew=1.0 * k, zorder=4.5, label="end",
    )  # fmt: skip
    ax.add_line(end)
    ax.add_line(start)
    way = Line2D(
        [], [], color=colour, lw=1.5, marker=robot_path(0.0), ms=8.0, mec=PAPER, mew=0.5,
        label="path",
    )  # fmt: skip
    return [_handle(start), way, _handle(end)]


def draw_finds(ax: Axes, episode: EpisodeLike) -> tuple[list[Any], list[Artist]]:
    """Mark each find with a tick where it was right and a cross where it was wrong.

    Return handles for a legend, and the discs drawn, which labels had better avoid.
    """
    finds = [
        (tuple(pose[:2]), reward > 0)
        for pose, action, reward in zip(
            list(episode.poses)[1:], episode.actions, episode.rewards, strict=True
        )
        if is_find(action)
    ]
    shown: dict[bool, Any] = {}
    drawn: list[Any] = []
    discs: list[Artist] = []
    for place, right in dict.fromkeys(finds):
        shown[right], disc = _verdict(ax, place, right, drawn.count(place))
        drawn.append(place)
        discs.append(disc)
    return [shown[right] for right in sorted(shown, reverse=True)], discs


def draw_questions(ax: Axes, poses: Sequence[tuple[float, ...]], questions: Sequence[Any]) -> Any:
    """Mark with a question mark where the robot was when something was asked; return a handle."""
    from matplotlib.lines import Line2D

    k = stroke(ax)
    style: dict[str, Any] = {
        "ls": "none", "marker": "$?$", "ms": 9.0 * k, "color": INK, "mew": 0.4 * k,
    }  # fmt: skip
    for step in dict.fromkeys(question.step for question in questions):
        x, y, *_ = poses[step]
        mark = Line2D([x], [y], zorder=5.4, gid="question", **style)
        mark.set_transform(ax.transData + _lifted(ax, -11.0 * k, 11.0 * k))
        ax.add_line(mark)
    return Line2D([], [], label="asked", **style)


def _lifted(ax: Axes, right_pt: float, up_pt: float) -> Any:
    from matplotlib.transforms import Affine2D, ScaledTranslation

    figure = ax.get_figure(root=True)
    if figure is None:
        return Affine2D()
    return ScaledTranslation(right_pt / 72, up_pt / 72, figure.dpi_scale_trans)


def _verdict(ax: Axes, place: tuple[float, float], right: bool, nth: int) -> tuple[Any, Artist]:
    """Draw one find above its pose, a white sign on a coloured disc; return handle and disc."""
    from matplotlib.lines import Line2D
    from matplotlib.path import Path
    from matplotlib.transforms import ScaledTranslation

    k = stroke(ax)
    colour = ACCENTS["right" if right else "wrong"]
    figure = ax.get_figure(root=True)
    moved = ax.transData
    if figure is not None:
        # Up and to the right by the size of the disc, further for each find at the same pose.
        lift = 11.0 * k / 72
        moved = moved + ScaledTranslation(lift * (1 + nth), lift, figure.dpi_scale_trans)
    codes = (
        [Path.MOVETO, Path.LINETO, Path.LINETO]
        if right
        else [Path.MOVETO, Path.LINETO, Path.MOVETO, Path.LINETO]
    )
    sign = Path(_TICK if right else _CROSS, codes)
    (x, y), label = place, f"find: {'right' if right else 'wrong'}"
    disc = Line2D(
        [x], [y], ls="none", marker="o", ms=10.0 * k, mfc=colour, mec=PAPER, mew=1.0 * k,
        transform=moved, zorder=5.2, gid="find-right" if right else "find-wrong",
    )  # fmt: skip
    stroke_line = Line2D(
        [x], [y], ls="none", marker=sign, ms=5.0 * k, mfc="none", mec=PAPER, mew=1.5 * k,
        transform=moved, zorder=5.3,
    )  # fmt: skip
    ax.add_line(disc)
    ax.add_line(stroke_line)
    back = Line2D(
        [], [], ls="none", marker="o", ms=8.5, mfc=colour, mec=PAPER, mew=0.8, label=label
    )
    front = Line2D([], [], ls="none", marker=sign, ms=4.2, mfc="none", mec=PAPER, mew=1.3)
    return (back, front), disc


def target_style(found: bool, imagined: bool) -> dict[str, Any]:
    """Return how a target is marked: filled when found, hollow when not, square when imagined."""
    colour = ACCENTS["truth"] if found else ACCENTS["wrong"]
    return {
        "marker": "s" if imagined else "D",
        "mfc": colour if found else PAPER,
        "mec": PAPER if found else colour,
        "mew": 1.0 if found else 1.8,
    }


def draw_targets(
    ax: Axes,
    places: Mapping[str, tuple[float, float]],
    found: Sequence[str],
    imagined: Sequence[str],
) -> list[Any]:
    """Mark the true place of each target and return handles for a legend, one for each sort."""
    from matplotlib.lines import Line2D

    k = stroke(ax)
    handles: dict[str, Any] = {}
    for name, (x, y) in places.items():
        style = target_style(name in found, name in imagined)
        size = 8.0 if name in found else 7.0
        mew = style.pop("mew")
        ax.add_line(Line2D([x], [y], ls="none", ms=size * k, mew=mew * k, zorder=5.0, **style))
        label = "target, found" if name in found else "target, not found"
        label += " (imagined)" if name in imagined else ""
        handles[label] = Line2D([], [], ls="none", ms=6.0, mew=mew, label=label, **style)
    return [handles[label] for label in sorted(handles)]


def _handle(line: Any) -> Any:
    """Return a legend handle that looks like a marker on the map."""
    from matplotlib.lines import Line2D

    return Line2D(
        [], [], ls="none", marker=line.get_marker(), ms=min(line.get_markersize(), 11.0),
        mfc=line.get_markerfacecolor(), mec=line.get_markeredgecolor(),
        mew=line.get_markeredgewidth(), label=line.get_label(), color=INK,
    )  # fmt: skip
