"""Colours of every figure: a clear and a muted map palette, and accents that all can tell apart."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.colors import ListedColormap

__all__ = [
    "ACCENTS",
    "CLEAR",
    "DARK",
    "INK",
    "MUTED",
    "PAPER",
    "TARGET_COLOURS",
    "MapPalette",
    "belief_colours",
    "belief_colours_on_dark",
    "difference_colours",
]

INK = "#22252b"
"""Text, frames and outlines."""

PAPER = "#ffffff"
"""Halos and boxes."""

ACCENTS = {
    "mentioned": "#0072b2",
    "frame": "#56b4e9",
    "truth": "#009e73",
    "mode": "#22252b",
    "path": "#0072b2",
    "view": "#56b4e9",
    "right": "#009e73",
    "wrong": "#d55e00",
    "prior": "#8a8f98",
}
"""What a mark means -> its colour. Source: Okabe and Ito, Color Universal Design (2008)."""

TARGET_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9")
"""Colours of the first, second, ... target or bar; used again from the start when they run out."""


@dataclass(frozen=True)
class MapPalette:
    """Colours of what is on a map; each is a hex string."""

    ground: str
    building: str
    building_edge: str
    road: str
    road_edge: str
    pedestrian: str
    parking: str
    parking_edge: str
    park: str
    park_edge: str
    water: str
    water_edge: str
    square: str
    sign: str
    poi: str
    label: str
    road_label: str
    water_label: str
    park_label: str


CLEAR = MapPalette(
    ground="#f5f2ea",
    building="#dccfbd",
    building_edge="#ab9c86",
    road="#ffffff",
    road_edge="#b4afa4",
    pedestrian="#a8794e",
    parking="#e6e8ec",
    parking_edge="#b3b8c2",
    park="#cbe3b4",
    park_edge="#93b876",
    water="#a8d0e8",
    water_edge="#6fa6c6",
    square="#ece3d6",
    sign="#54809c",
    poi="#7a3e6f",
    label="#2b2721",
    road_label="#55524b",
    water_label="#1f5a80",
    park_label="#36601f",
)
"""A map to read."""

MUTED = MapPalette(
    ground="#f5f5f4",
    building="#e1e1df",
    building_edge="#bcbcb9",
    road="#ffffff",
    road_edge="#cfcfcc",
    pedestrian="#b5b5b1",
    parking="#eeeeed",
    parking_edge="#d4d4d1",
    park="#e3eadd",
    park_edge="#c6d1bd",
    water="#d8e4ea",
    water_edge="#b9cbd5",
    square="#ededeb",
    sign="#bfc3c7",
    poi="#6e6e6a",
    label="#4a4a48",
    road_label="#66665f",
    water_label="#5c7482",
    park_label="#66755c",
)
"""A map to lay something over."""

DARK = MapPalette(
    ground="#14171c",
    building="#262b33",
    building_edge="#424a56",
    road="#30363f",
    road_edge="#1d2127",
    pedestrian="#4a5059",
    parking="#1d2229",
    parking_edge="#333a44",
    park="#1b2a20",
    park_edge="#2d4434",
    water="#17303f",
    water_edge="#27495c",
    square="#20242a",
    sign="#5f7d92",
    poi="#b48cab",
    label="#d9dce1",
    road_label="#a7adb6",
    water_label="#8fb8cf",
    park_label="#9cc19f",
)
"""A map to lay something over, on a dark screen."""


@cache
def belief_colours() -> ListedColormap:
    """Return the colour map of probabilities: clear where there is none, dark where there is most.

    Lightness falls evenly from yellow to near black (matplotlib's inferno, reversed and cut at
    both ends), while opacity rises quickly from zero.
    """
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    t = np.linspace(0.0, 1.0, 256)
    # Cut at both ends: the palest yellow vanishes on paper, black hides outlines.
    rgba = np.asarray(colormaps["inferno_r"](0.06 + 0.82 * t))
    # Opaque from 0.3 of the peak on, but never quite: streets stay visible under a belief.
    rgba[:, 3] = 0.92 * np.minimum(1.0, t / 0.3) ** 0.85
    return ListedColormap([tuple(c) for c in rgba], name="sloop_belief")


@cache
def belief_colours_on_dark() -> ListedColormap:
    """Return the colours of probabilities for a dark ground: bright where there is most."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    rgba = np.asarray(colormaps["inferno"](np.linspace(0.3, 0.98, 256)))
    rgba[:, 3] = belief_colours()(np.linspace(0, 1, 256))[:, 3]
    return ListedColormap([tuple(c) for c in rgba], name="sloop_belief_on_dark")


@cache
def difference_colours() -> ListedColormap:
    """Return the colour map of changes: vermilion for less, clear for none, blue for more."""
    from matplotlib.colors import LinearSegmentedColormap, ListedColormap

    base = LinearSegmentedColormap.from_list(
        "sloop_change", ["#7a2c00", "#d55e00", "#f4efe9", "#0072b2", "#003a5c"]
    )
    # An odd number of colours, so that no change has one of its own, the clear one in the middle.
    t = np.linspace(0.0, 1.0, 255)
    rgba = np.asarray(base(t))
    # Changes are small nearly everywhere: opaque from a quarter of the greatest on.
    rgba[:, 3] = 0.92 * np.minimum(1.0, np.abs(2 * t - 1) / 0.25) ** 0.6
    return ListedColormap([tuple(c) for c in rgba], name="sloop_difference")
