"""Figures: maps, beliefs, frames and searches, drawn with matplotlib on the axes that are given."""

from sloop_ppl.plots.animation import animate_search
from sloop_ppl.plots.belief import plot_belief, plot_beliefs
from sloop_ppl.plots.city import plot_map
from sloop_ppl.plots.formats import (
    animation_formats,
    check_figure_path,
    figure_formats,
    save_figure,
)
from sloop_ppl.plots.search import plot_search

__all__ = [
    "animate_search",
    "animation_formats",
    "check_figure_path",
    "figure_formats",
    "plot_belief",
    "plot_beliefs",
    "plot_map",
    "plot_search",
    "save_figure",
]
