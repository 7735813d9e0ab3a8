"""Figures: maps, beliefs, frames and searches, drawn with matplotlib on the axes that are given."""

from sloop_ppl.plots import _backend  # noqa: F401 - before matplotlib is imported
from sloop_ppl.plots.animation import animate_search, search_frames
from sloop_ppl.plots.bars import plot_components, plot_influence, plot_latent, plot_words
from sloop_ppl.plots.belief import plot_belief, plot_beliefs
from sloop_ppl.plots.belief_parts import plot_change, plot_relations
from sloop_ppl.plots.blocks import plot_blocks
from sloop_ppl.plots.city import plot_map
from sloop_ppl.plots.context import plot_context
from sloop_ppl.plots.deviations import draw_deviations, plot_deviations
from sloop_ppl.plots.formats import (
    animation_formats,
    check_figure_path,
    figure_formats,
    save_figure,
)
from sloop_ppl.plots.frame import frame_bins, plot_frame, plot_frames
from sloop_ppl.plots.search import plot_search
from sloop_ppl.plots.sheet import FrameRose, SheetParts, plot_sheet, plot_sheets

__all__ = [
    "FrameRose",
    "SheetParts",
    "animate_search",
    "animation_formats",
    "check_figure_path",
    "draw_deviations",
    "figure_formats",
    "frame_bins",
    "plot_belief",
    "plot_beliefs",
    "plot_blocks",
    "plot_change",
    "plot_components",
    "plot_context",
    "plot_deviations",
    "plot_frame",
    "plot_frames",
    "plot_influence",
    "plot_latent",
    "plot_map",
    "plot_relations",
    "plot_search",
    "plot_sheet",
    "plot_sheets",
    "plot_words",
    "save_figure",
    "search_frames",
]
