"""Animate a search: the robot, what it sees, and how the belief follows."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.maps import CityMap
from sloop_ppl.outputs import written_whole
from sloop_ppl.plots._belief import draw_cells
from sloop_ppl.plots._glyphs import collected_glyphs, tell_missing
from sloop_ppl.plots._palette import ACCENTS, INK, PAPER, belief_colours
from sloop_ppl.plots._protocols import EpisodeLike
from sloop_ppl.plots._robot import is_find, robot_path, seen_image, target_style
from sloop_ppl.plots._video_files import find_ffmpeg, write_gif, write_mp4
from sloop_ppl.plots.city import draw_map
from sloop_ppl.plots.formats import check_figure_path
from sloop_ppl.plots.search import along, together

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure
    from PIL.Image import Image

__all__ = ["animate_search", "search_frames"]

Beliefs = Mapping[str, NDArray[np.float64]]
_SIZE_IN = (6.4, 6.9)
_DPI = 100


def animate_search(
    episode: EpisodeLike,
    city: CityMap,
    path: str | Path,
    *,
    beliefs: Sequence[Beliefs] | Beliefs | None = None,
    fps: float = 4.0,
    imagined: Sequence[str] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write a search as a GIF, or as an MP4 where ffmpeg is installed: one frame a pose.

    Parameters
    ----------
    episode
        The search.
    city
        Its map.
    path
        Where to write it; it ends in .gif or .mp4.
    beliefs
        Belief of each target at each pose, or one that stays; the episode's own, if it kept them,
        when None. Each is scaled to its peak; those of found targets are left out.
    fps
        Frames a second, > 0.
    imagined
        Targets whose true place was drawn rather than given.
    progress
        Called with the number of frames done and that of all.

    Returns
    -------
    pathlib.Path
        The file written.

    Raises
    ------
    InputError
        When the ending is unknown, ffmpeg is missing for an .mp4, `fps` is not positive or there
        are neither one nor as many beliefs as poses.
    OutputError
        When the file cannot be written.
    """
    chosen = check_figure_path(path, animation=True)
    film = chosen.suffix.lower() == ".mp4"
    ffmpeg = find_ffmpeg() if film else ""
    if not fps > 0:
        raise InputError(f"fps is {fps}; expected a positive number of frames a second")
    count = len(episode.poses)
    frames: list[Image] = []
    with collected_glyphs() as missing:
        scene = _Scene(episode, city, _by_pose(episode, beliefs), tuple(imagined))
        for step in range(count):
            frames.append(scene.frame(step))
            if progress is not None:
                progress(step + 1, count)
    try:
        with written_whole(chosen) as whole:
            if film:
                write_mp4(frames, whole, fps, ffmpeg)
            else:
                write_gif(frames, whole, fps)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(
            f"Animation '{path}' cannot be written: {error.strerror or error}"
        ) from error
    tell_missing(missing, f"Animation '{path}'")
    return chosen


def search_frames(
    episode: EpisodeLike,
    city: CityMap,
    *,
    beliefs: Sequence[Beliefs] | Beliefs | None = None,
    imagined: Sequence[str] = (),
) -> list[Image]:
    """Return the pictures of an animation, one a pose.

    Parameters
    ----------
    episode, city, beliefs, imagined
        As in `animate_search`.

    Returns
    -------
    list of PIL.Image.Image
        Pictures of equal and even size.
    """
    with collected_glyphs() as missing:
        scene = _Scene(episode, city, _by_pose(episode, beliefs), tuple(imagined))
        frames = [scene.frame(step) for step in range(len(episode.poses))]
    tell_missing(missing, "The animation")
    return frames


def _by_pose(
    episode: EpisodeLike, beliefs: Sequence[Beliefs] | Beliefs | None
) -> Sequence[Beliefs]:
    """Return as many beliefs as poses, or none."""
    count = len(episode.poses)
    given = getattr(episode, "beliefs", ()) if beliefs is None else beliefs
    listed: list[Beliefs] = [given] * count if isinstance(given, Mapping) else list(given)
    if len(listed) not in (0, count):
        raise InputError(
            f"There are {len(listed)} beliefs for {count} poses; expected one for each pose, or "
            "one mapping that stays"
        )
    return listed


class _Scene:
    """The map drawn once, and the few things on it that move."""

    def __init__(
        self,
        episode: EpisodeLike,
        city: CityMap,
        beliefs: Sequence[Beliefs],
        imagined: tuple[str, ...],
    ) -> None:
        from matplotlib.figure import Figure

        from sloop_ppl.plots._labels import Label

        self.episode, self.city, self.beliefs, self.imagined = episode, city, beliefs, imagined
        self.figure = Figure(figsize=_SIZE_IN, dpi=_DPI, facecolor=PAPER)
        self.canvas: Any = _canvas(self.figure)
        self.ax = self.figure.add_axes((0.085, 0.06, 0.905, 0.84))
        self.labels = layer = draw_map(self.ax, city, muted=True, cells=True)
        names = [
            Label(name, shapely.Point(*at), INK, 1.06, "bold", must=True, gap_pt=7.0)
            for name, at in episode.places.items()
        ]
        layer.labels = (*names, *layer.labels)
        layer.avoid(points=along(episode.poses, city.grid.cell_m))
        self.figure.legend(
            handles=self._key(), loc="upper right", ncol=2, fontsize=7.5, frameon=False,
            bbox_to_anchor=(0.995, 0.998), labelcolor=INK, columnspacing=1.2, handlelength=1.4,
        )  # fmt: skip
        # What lies above the labels is drawn again on top of what moves below them.
        over = [a for a in self.ax.get_children() if a.get_zorder() >= layer.get_zorder()]
        self.below, self.above = self._movers()
        for artist in (*over, *self.below.values(), *self.above.values()):
            artist.set_animated(True)
        self.canvas.draw()
        # The map is drawn once and restored for each frame.
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)
        self.names = self._alone(over)

    def frame(self, step: int) -> Image:
        """Return the picture of one pose."""
        from PIL import Image as Pictures

        self._set(step)
        self.canvas.restore_region(self.background)
        renderer = self.canvas.get_renderer()
        for artist in self.below.values():
            artist.draw(renderer)
        pixels = np.asarray(self.canvas.buffer_rgba())
        rows, cols, colour, opacity = self.names
        under = pixels[rows, cols, :3]
        # Alpha blending of the labels, kept as pixels: out = under * (1 - a) + colour * a.
        pixels[rows, cols, :3] = under + (colour - under) * opacity
        for artist in self.above.values():
            artist.draw(renderer)
        # yuv420p halves the colour resolution, so sides must be even.
        even = pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2, :3]
        return Pictures.fromarray(np.ascontiguousarray(even))

    def _alone(self, artists: Sequence[Artist]) -> tuple[Any, Any, Any, Any]:
        """Return where artists leave colour, which, and how opaque, drawn on nothing."""
        renderer = self.canvas.get_renderer()
        renderer.clear()
        for artist in sorted(artists, key=lambda a: a.get_zorder()):
            artist.draw(renderer)
        pixels = np.asarray(self.canvas.buffer_rgba()).astype(float)
        rows, cols = np.nonzero(pixels[..., 3])
        chosen = pixels[rows, cols]
        return rows, cols, chosen[:, :3], chosen[:, 3:] / 255.0

    def _movers(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return what moves below the names and what moves above them, in drawing order."""
        ax, blue, places = self.ax, ACCENTS["path"], self.episode.places
        blank = np.zeros((*self.city.grid.shape, 4))
        x, y = self.episode.poses[0][:2]
        below = {
            "cells": draw_cells(ax, blank, self.city.grid, zorder=2.0, vmin=None),
            "way": ax.plot([], [], color=blue, lw=1.6)[0],
            "start": ax.plot([x], [y], "o", mfc=PAPER, mec=blue, ms=7, mew=1.6)[0],
        }
        marks = {f"target {name}": ax.plot(*at, ls="none", ms=8)[0] for name, at in places.items()}
        robot = ax.plot([], [], ls="none", ms=17, mfc=blue, mec=PAPER, mew=1.1)[0]
        sign = ax.plot([], [], ls="none", marker="o", mfc="none", ms=26, mew=3.0)[0]
        style: dict[str, Any] = {"color": INK, "parse_math": False}
        above = {
            **marks,
            "robot": robot,
            "sign": sign,
            "head": self.figure.text(0.085, 0.957, "", fontsize=11, **style),
            "caption": self.figure.text(0.085, 0.919, "", fontsize=9, **style),
        }
        return below, above

    def _key(self) -> list[Any]:
        """Return handles for a legend of what moves."""
        from matplotlib.colors import to_rgb
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        sky = to_rgb(ACCENTS["view"])
        handles: list[Any] = [
            Patch(facecolor=(*sky, 0.6), label="in view"),
            Patch(facecolor=(*sky, 0.25), label="seen before"),
        ]
        if self.beliefs:
            handles.append(Patch(facecolor=belief_colours()(0.45), label="believed"))
        for found, label in ((False, "target"), (True, "target, found")):
            style = target_style(found, False)
            handles.append(Line2D([], [], ls="none", ms=6, label=label, **style))
        return handles

    def _set(self, step: int) -> None:
        """Move everything to where it is at one pose."""
        episode, show = self.episode, {**self.below, **self.above}
        x, y, heading = (float(v) for v in episode.poses[step])
        found = self._found(step)
        show["cells"].set_data(self._cells(step, found))
        track = np.array([p[:2] for p in episode.poses[: step + 1]], dtype=float)
        show["way"].set_data(track[:, 0], track[:, 1])
        show["robot"].set_data([x], [y])
        show["robot"].set_marker(robot_path(heading))
        for name in episode.places:
            show[f"target {name}"].set(**target_style(name in found, name in self.imagined))
        find = step > 0 and is_find(episode.actions[step - 1])
        right = find and episode.rewards[step - 1] > 0
        show["sign"].set_data([x] if find else [], [y] if find else [])
        show["sign"].set_markeredgecolor(ACCENTS["right" if right else "wrong"])
        show["head"].set_text(self._headline(step))
        show["caption"].set_text(textwrap.shorten(self._caption(step), 100, placeholder=" …"))

    def _cells(self, step: int, found: Sequence[str]) -> NDArray[np.float64]:
        """Return the RGBA image of what was seen, what is believed and what is in view."""
        views, shape = self.episode.views, self.city.grid.shape
        image = seen_image(views[: step + 1], shape, 0.13)
        if self.beliefs:
            left = {n: b for n, b in self.beliefs[step].items() if n not in found}
            image = _over(np.asarray(belief_colours()(together(left, self.city))), image)
        return _over(seen_image(views[step], shape, 0.5), image)

    def _found(self, step: int) -> tuple[str, ...]:
        """Return the targets found by a step: a right find marks all that were in view."""
        done: list[str] = []
        for i in range(step):
            if is_find(self.episode.actions[i]) and self.episode.rewards[i] > 0:
                view = np.asarray(self.episode.views[i])
                for name, (x, y) in self.episode.places.items():
                    named = self.episode.actions[i] in ("find", f"find({name})")
                    seen = named and bool(view[self.city.grid.cell_at(x, y)])
                    if seen and name not in done and name in self.episode.found_targets:
                        done.append(name)
        if step == len(self.episode.actions):
            return tuple(self.episode.found_targets)
        return tuple(done)

    def _headline(self, step: int) -> str:
        count = len(self.episode.actions)
        action = "start" if step == 0 else str(self.episode.actions[step - 1]).replace("_", " ")
        return f"Step {step} of {count}: {action}"

    def _caption(self, step: int) -> str:
        asked = [q for q in getattr(self.episode, "questions", ()) if q.step == step]
        if asked:
            answers = "; ".join(q.answer or "no answer" for q in asked)
            return textwrap.shorten(f"asked, and was answered: {answers}", 60, placeholder=" …")
        if step == 0:
            return "Looking for " + ", ".join(self.episode.places)
        reward = f"reward {self.episode.rewards[step - 1]:+g}".replace("-", "−")
        found = self._found(step)
        new = [n for n in found if n not in self._found(step - 1)]
        seen = [n for n, at in dict(self.episode.observations[step - 1]).items() if at is not None]
        parts = [f"found {', '.join(new)}"] if new else []
        if not new and is_find(self.episode.actions[step - 1]):
            parts = ["nothing found here"]
        parts += [f"sees {', '.join(seen)}"] if seen else [] if new else ["sees nothing"]
        return ", ".join([*parts, reward])


def _canvas(figure: Figure) -> Any:
    """Return an Agg canvas, most of whose methods have no types."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    return FigureCanvasAgg(figure)


def _over(top: NDArray[np.float64], bottom: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lay one RGBA image over another."""
    # Porter and Duff, over: alpha = a + b (1 - a), colours weighed by them.
    a, b = top[..., 3:], bottom[..., 3:] * (1.0 - top[..., 3:])
    alpha = a + b
    colour = (top[..., :3] * a + bottom[..., :3] * b) / np.where(alpha > 0, alpha, 1.0)
    return np.concatenate([colour, alpha], axis=-1)
