"""Find a free place for each of many labels, one after the other."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from shapely.geometry.base import BaseGeometry

from sloop_ppl.plots._axes import font_pt
from sloop_ppl.plots._ground import areas_of
from sloop_ppl.plots._palette import PAPER

if TYPE_CHECKING:
    from matplotlib.axes._base import _AxesBase
    from matplotlib.backend_bases import RendererBase
    from matplotlib.figure import Figure

__all__ = ["Label", "Placed", "Placer"]

# Letters a line: in one line, then narrower and narrower.
_WRAPS = (99, 22, 15, 11)
# Sizes to try: as asked for, then a little smaller; below that a label is dropped.
_SHRINK = (1.0, 0.87)
# Free space left and right of a label, and above and below it, points.
_PAD_PT = (2.2, 1.2)
# Where along a line the middle of its label may be: the middle first, then towards the ends.
_ALONG = (0.5, 0.38, 0.62, 0.25, 0.75, 0.15, 0.85)
# How far a line may bend away under its label, in heights of the label.
_STRAIGHT = 0.35


@dataclass(frozen=True)
class Label:
    """A name that is to stand somewhere.

    Parameters
    ----------
    geometry
        What it names, metres: a point, a line or an area.
    size
        Size as a multiple of the map's label size.
    must
        True when it is to be placed even where it overhangs what it names.
    gap_pt
        How far off a point it stands, points.
    """

    text: str
    geometry: BaseGeometry
    colour: str
    size: float = 1.0
    weight: str = "normal"
    style: str = "normal"
    must: bool = False
    gap_pt: float = 3.2


@dataclass(frozen=True)
class Placed:
    """A label in its place: the text as drawn and the box that it fills, pixels."""

    label: Label
    text: Text
    box: BaseGeometry

    def moved(self, right: float, up: float) -> Placed:
        """Return the label so many pixels further on; its text is moved, not copied."""
        x, y = self.text.get_position()
        self.text.set_position((x + right, y + up))
        return Placed(self.label, self.text, shapely.affinity.translate(self.box, right, up))


@dataclass(frozen=True)
class _Spot:
    """Where a label could stand: centre in pixels, rotation in degrees, lines and cost."""

    x: float
    y: float
    degrees: float
    text: str
    size: float
    cost: float


class Placer:
    """One go at placing labels on an axes of known size."""

    def __init__(self, axes: _AxesBase, figure: Figure, renderer: RendererBase) -> None:
        self.figure, self.renderer = figure, renderer
        self.px_per_pt = figure.dpi / 72
        self.base_pt = font_pt(axes.bbox.width / figure.dpi)
        x0, y0, x1, y1 = axes.bbox.extents
        # A pixel off the frame, which would touch the letters.
        self.window = shapely.box(x0 + 1, y0 + 1, x1 - 1, y1 - 1)
        origin, step = axes.transData.transform([(0.0, 0.0), (1.0, 1.0)])
        self.scale = np.asarray(step - origin)
        self.origin = np.asarray(origin)
        self.taken: list[BaseGeometry] = []
        self.bounds = np.empty((0, 4))
        self.dots = np.empty((0, 2))
        self._limit = math.inf  # spots of at least this cost are not needed, nor measured
        self._sizes: dict[tuple[str, float, str, str], tuple[float, float]] = {}

    def block(self, box: Bbox) -> None:
        """Keep labels off a box in pixels."""
        if box.width > 0 and box.height > 0:
            self._take(shapely.box(*box.extents))

    def block_points(self, points: Sequence[tuple[float, float]]) -> None:
        """Keep labels off small discs round points in metres."""
        for x, y in points:
            # Discs of 2.5 points, about the radius of a small marker.
            self._take(shapely.Point(*self.pixels(x, y)).buffer(2.5 * self.px_per_pt))

    def pixels(self, x: float, y: float) -> tuple[float, float]:
        """Return the pixel of a point in metres."""
        px, py = self.origin + self.scale * (x, y)
        return float(px), float(py)

    def place_all(self, labels: Sequence[Label]) -> Iterator[Placed]:
        """Yield the labels that find a place, in the order given."""
        shapes = [
            shapely.transform(m.geometry, lambda p: self.origin + self.scale * p) for m in labels
        ]
        dots = [(s.x, s.y) for s in shapes if s.geom_type == "Point"]
        self.dots = np.reshape(np.array(dots, dtype=float), (-1, 2))
        for label, shape in zip(labels, shapes, strict=True):
            best: tuple[float, _Spot, BaseGeometry] | None = None
            # Costs of places run from 0, ideal, to about 1, poor; a label that must stand takes
            # any.
            self._limit = 9.0 if label.must else 1.0
            for spot in self._spots(label, shape):
                if spot.cost >= self._limit:
                    continue
                box = self._box(label, spot)
                if not self._free(box):
                    continue
                # Hiding the dot of another place costs as much as seven worse sides.
                cost = spot.cost + 0.3 * self._dots_under(box)
                if cost < self._limit:
                    best, self._limit = (cost, spot, box), cost
            if best is not None:
                _, spot, box = best
                self._take(box)
                yield Placed(label, self._text(label, spot), box)

    def _take(self, shape: BaseGeometry) -> None:
        self.taken.append(shape)
        self.bounds = np.vstack([self.bounds, shape.bounds])

    def _free(self, box: BaseGeometry) -> bool:
        """Tell whether a box lies inside the axes and touches nothing that is taken."""
        x0, y0, x1, y1 = box.bounds
        left, low, right, high = self.window.bounds
        if x0 < left or y0 < low or x1 > right or y1 > high:
            return False
        b = self.bounds
        near = np.nonzero((b[:, 0] <= x1) & (b[:, 2] >= x0) & (b[:, 1] <= y1) & (b[:, 3] >= y0))[0]
        return not any(box.intersects(self.taken[i]) for i in near)

    def _dots_under(self, box: BaseGeometry) -> int:
        """Return how many places' dots a box would hide."""
        x0, y0, x1, y1 = box.bounds
        gap = 2.2 * self.px_per_pt
        x, y = self.dots.T
        near = (x >= x0 - gap) & (x <= x1 + gap) & (y >= y0 - gap) & (y <= y1 + gap)
        return int(near.sum())

    def _spots(self, label: Label, shape: BaseGeometry) -> Iterator[_Spot]:
        kinds: dict[str, Callable[[Label, BaseGeometry], Iterator[_Spot]]] = {
            "Point": self._round_point,
            "LineString": self._along_line,
            "MultiLineString": self._along_line,
        }
        yield from kinds.get(shape.geom_type, self._in_area)(label, shape)

    def _round_point(self, label: Label, point: BaseGeometry) -> Iterator[_Spot]:
        gap = label.gap_pt * self.px_per_pt
        # Right of the point, left, above, below, then the corners: each rank costs 0.04.
        ways = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
        for k, text in enumerate(_wrapped(label.text)):
            if 0.06 * k >= self._limit:
                return
            size = self.base_pt * label.size
            w, h = self._measure(text, size, label)
            for rank, (dx, dy) in enumerate(ways):
                x = point.x + dx * (w / 2 + gap * (0.75 if dy else 1))
                # At a corner three quarters of the gap on each axis are as far off.
                y = point.y + dy * (h / 2 + gap * (0.75 if dx else 1))
                yield _Spot(x, y, 0.0, text, size, 0.04 * rank + 0.06 * k)

    def _in_area(self, label: Label, area: BaseGeometry) -> Iterator[_Spot]:
        seen = areas_of(shapely.intersection(shapely.make_valid(area), self.window))
        if seen.is_empty:
            yield from self._round_point(label, shapely.centroid(area))
            return
        # A label may overhang by 1.5 points before that counts as outside.
        whole = seen.buffer(1.5 * self.px_per_pt)
        middle = shapely.get_coordinates(shapely.centroid(seen))[0]
        roomy = shapely.get_coordinates(shapely.maximum_inscribed_circle(seen))[0]
        west, south, east, north = seen.bounds
        grid = [
            (west + (east - west) * u, south + (north - south) * v)
            for u in (0.5, 0.35, 0.65, 0.2, 0.8)
            for v in (0.5, 0.35, 0.65, 0.2, 0.8)
        ]
        centres = np.array([tuple(middle), tuple(roomy), *grid])
        reach = float(np.hypot(east - west, north - south)) or 1.0
        for shrink in _SHRINK:
            for k, text in enumerate(_wrapped(label.text)):
                if 0.04 * k + (1 - shrink) >= self._limit:
                    break
                size = self.base_pt * label.size * shrink
                w, h = self._measure(text, size, label)
                half = np.array([w / 2, h / 2])
                boxes = shapely.box(*(centres - half).T, *(centres + half).T)
                outside = 1.0 - shapely.area(shapely.intersection(boxes, whole)) / shapely.area(
                    boxes
                )
                for (x, y), out in zip(centres, outside.tolist(), strict=True):
                    # More than 62 % outside and nobody would know what it names.
                    if out > (0.9 if label.must else 0.62):
                        continue
                    off = float(np.hypot(x - middle[0], y - middle[1])) / reach
                    # Outside weighs most, then off the middle, then more lines or smaller letters.
                    cost = 1.1 * out + 0.5 * off + 0.04 * k + (1 - shrink)
                    yield _Spot(float(x), float(y), 0.0, text, size, cost)

    def _along_line(self, label: Label, line: BaseGeometry) -> Iterator[_Spot]:
        seen = shapely.line_merge(shapely.intersection(line, self.window))
        parts = [p for p in shapely.get_parts(seen) if p.geom_type == "LineString"]
        for part in sorted(parts, key=lambda p: -p.length):
            for shrink in _SHRINK:
                if 1 - shrink >= self._limit:
                    break
                size = self.base_pt * label.size * shrink
                w, h = self._measure(label.text, size, label)
                if w > part.length:
                    continue
                for rank, at in enumerate(_ALONG):
                    middle = float(np.clip(at * part.length, w / 2, part.length - w / 2))
                    # Nine points under the label tell whether the line is straight enough for it.
                    steps = np.linspace(middle - w / 2, middle + w / 2, 9)
                    track = shapely.get_coordinates(shapely.line_interpolate_point(part, steps))
                    chord = track[-1] - track[0]
                    along = float(np.hypot(*chord))
                    # The chord is much shorter than the line: it turns back under the label.
                    if along < 0.9 * w:
                        continue
                    # Distance of the points from the chord, left of it positive: cross product over
                    # its length.
                    away = (track - track[0]) @ np.array([-chord[1], chord[0]]) / along
                    if np.ptp(away) > _STRAIGHT * h and not label.must:
                        continue
                    x, y = (track[0] + track[-1]) / 2 + np.array([-chord[1], chord[0]]) / along * (
                        (away.max() + away.min()) / 2
                    )
                    degrees = float(np.degrees(np.arctan2(chord[1], chord[0])))
                    degrees = (degrees + 80.0) % 180.0 - 80.0  # upward when steep
                    # Off the middle of the line, smaller, or bent by a height each cost about the
                    # same.
                    cost = 0.05 * rank + (1 - shrink) + 0.2 * float(np.ptp(away)) / h
                    yield _Spot(float(x), float(y), degrees, label.text, size, cost)

    def _measure(self, text: str, size: float, label: Label) -> tuple[float, float]:
        key = (text, size, label.weight, label.style)
        if key not in self._sizes:
            box = self._text(label, _Spot(0.0, 0.0, 0.0, text, size, 0.0)).get_window_extent(
                self.renderer
            )
            across, up = (2 * pad * self.px_per_pt for pad in _PAD_PT)
            self._sizes[key] = box.width + across, box.height + up
        return self._sizes[key]

    def _box(self, label: Label, spot: _Spot) -> BaseGeometry:
        w, h = self._measure(spot.text, spot.size, label)
        box = shapely.box(spot.x - w / 2, spot.y - h / 2, spot.x + w / 2, spot.y + h / 2)
        return shapely.affinity.rotate(box, spot.degrees) if spot.degrees else box

    def _text(self, label: Label, spot: _Spot) -> Text:
        from matplotlib.patheffects import withStroke

        text = Text(
            spot.x,
            spot.y,
            spot.text,
            color=label.colour,
            fontsize=spot.size,
            fontweight=label.weight,
            fontstyle=label.style,
            rotation=spot.degrees,
            rotation_mode="anchor",
            ha="center",
            va="center",
            multialignment="center",
            linespacing=1.1,
            parse_math=False,
            path_effects=[withStroke(linewidth=1.7, foreground=PAPER, alpha=0.85)],
        )
        text.set_figure(self.figure)
        return text


def _wrapped(text: str) -> tuple[str, ...]:
    """Return the text in one line and, where that differs, in narrower and narrower ones."""
    ways = []
    text = text.replace(" - ", "\u00a0- ")  # a dash ends a line, it does not begin one
    for width in _WRAPS:
        lines = textwrap.wrap(text, width, break_long_words=False)
        if len(lines) > 4:
            break
        ways.append("\n".join(_balanced(text, len(lines))))
    return tuple(dict.fromkeys(ways))


def _balanced(text: str, count: int) -> list[str]:
    """Wrap into so many lines, the longest as short as can be."""
    for width in range(1, len(text) + 1):
        lines = textwrap.wrap(text, width, break_long_words=False)
        if len(lines) <= count:
            return lines
    return [text]
