"""Put the names of landmarks on a map so that no two overlap, whatever the size it is drawn at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist

from sloop_ppl.plots._placing import Label, Placed, Placer

if TYPE_CHECKING:
    from matplotlib.backend_bases import RendererBase

__all__ = ["Label", "LabelLayer", "Placed"]


class LabelLayer(Artist):
    """All labels of a map; finds their places whenever it is drawn at another size.

    Parameters
    ----------
    labels
        What to place, most wanted first.
    obstacles
        Artists whose boxes no label may touch.
    points
        ``(x, y)`` in metres that labels keep clear of, shape (n, 2).

    Notes
    -----
    Greedy: each label takes the cheapest place that is free; one that has none is dropped.
    """

    def __init__(
        self,
        labels: Sequence[Label],
        obstacles: Sequence[Artist] = (),
        points: Sequence[tuple[float, float]] = (),
    ) -> None:
        super().__init__()
        self.labels = tuple(labels)
        self.obstacles = list(obstacles)
        self.points = list(points)
        self.set_zorder(6.0)
        # Else the layout engine would make room for labels that are placed after it has run.
        self.set_in_layout(False)
        self._done: tuple[Any, Any, tuple[Placed, ...]] | None = None

    def avoid(self, *artists: Artist, points: Sequence[tuple[float, float]] = ()) -> None:
        """Keep labels off these artists and points, too."""
        self.obstacles.extend(artists)
        self.points.extend(points)
        self._done = None

    def draw(self, renderer: RendererBase) -> None:
        """Draw the labels that found a place."""
        if not self.get_visible():
            return
        for placed in self.place(renderer):
            placed.text.draw(renderer)
        self.stale = False

    def forget(self) -> None:
        """Place the labels anew when they are drawn next, as after a change of fonts."""
        self._done = None

    def place(self, renderer: RendererBase) -> tuple[Placed, ...]:
        """Return the labels in their places for the axes as it lies on this renderer."""
        axes = self.axes
        figure = self.get_figure(root=True)
        if axes is None or figure is None:
            return ()
        # Places hold for one size, part of the map, resolution and renderer, which measures text.
        key = (
            round(float(axes.bbox.width), 3),
            round(float(axes.bbox.height), 3),
            *axes.viewLim.bounds,
            figure.dpi,
            len(self.obstacles),
            type(renderer).__name__,
        )
        at = np.array([axes.bbox.x0, axes.bbox.y0])
        if self._done is None or self._done[0] != key:
            placer = Placer(axes, figure, renderer)
            for artist in self.obstacles:
                if artist.get_visible():
                    placer.block(artist.get_window_extent(renderer))
            placer.block_points(self.points)
            self._done = key, at, tuple(placer.place_all(self.labels))
        # The layout engine moves an axes without another size: the labels go along.
        shift = at - self._done[1]
        if np.abs(shift).max() > 0:
            self._done = key, at, tuple(p.moved(*shift) for p in self._done[2])
        return self._done[2]
