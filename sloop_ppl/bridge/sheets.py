"""Gather what explains each belief of a posterior and draw it on one sheet.

Tables are read as arrays: xarray, which their labelled forms need, takes half a second to load.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.bridge.relation_text import percent, relations_in_words
from sloop_ppl.inference.factors import site_name
from sloop_ppl.inference.frames import FramePosterior, frame_masses
from sloop_ppl.plots import FrameRose, SheetParts, plot_sheets

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sloop_ppl.inference import Posterior

__all__ = ["figure_of", "sheet_of"]

# Components below half a per cent are not drawn: they would read 0 %.
_NEGLIGIBLE = 0.005
# Places that are less probably meant are not marked.
_LEAST_SHARE = 0.02
# Petals of a rose, five degrees each.
_DIRECTIONS = 72


def figure_of(
    posterior: Posterior,
    truths: Mapping[str, tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,
) -> Figure:
    """Draw a sheet for every target; see :func:`sheet_of`.

    Parameters
    ----------
    posterior
        What is believed.
    truths
        True places of targets, metres, as far as they are known.
    rng
        Wanted by engines that draw.
    """
    known = truths or {}
    return plot_sheets(
        posterior, {t: sheet_of(posterior, t, known.get(t), rng) for t in posterior.targets}
    )


def sheet_of(
    posterior: Posterior,
    target: str,
    truth: tuple[float, float] | None = None,
    rng: np.random.Generator | None = None,
) -> SheetParts:
    """Return what explains the belief of one target.

    Relation by relation (when there are several), component by component (when there are), the
    components before and after, the influence of each relation, the fronts on their landmarks,
    and the prior.
    """
    relations = posterior.relations(target)
    if not relations:
        return SheetParts(truth=truth)
    grid = posterior.city.grid
    words = relations_in_words(posterior, target)
    several = len(relations) > 1 and not posterior.model.needs_truth
    weights = {k: w for k, w in posterior.component_prior(target).items() if w}
    components = {k: p for k, p in posterior.component(target).items() if k in weights}
    return SheetParts(
        parts=dict(zip(words, posterior.phrase_tables(target), strict=True)) if several else {},
        grounds=_grounds(posterior, target, words),
        component_maps=_component_maps(posterior, target) if len(components) > 1 else {},
        components=components if len(components) > 1 else {},
        component_prior=weights,
        influence=dict(zip(words, (i.bits for i in posterior.influence(target, rng)), strict=True))
        if several
        else {},
        roses=_roses(posterior, target),
        prior=np.exp(posterior.log_prior[target]).reshape(grid.shape),
        truth=truth,
    )


def _grounds(posterior: Posterior, target: str, words: tuple[str, ...]) -> dict[str, list[str]]:
    """Return, for each relation, the places it may be about that are probable enough to mark."""
    marked: dict[str, list[str]] = {word: [] for word in words}
    for ground in posterior.grounds(target):
        likely = [c for c in ground.candidates if c.p >= _LEAST_SHARE]
        places = [c.ground for c in likely if c.ground is not None and c.ground in posterior.city]
        marked[words[ground.index]] += places
    return marked


def _component_maps(posterior: Posterior, target: str) -> dict[str, np.ndarray]:
    """Return the belief given each component that has a share worth drawing."""
    # The last description that speaks of the target: its components are those that count now.
    which = max(i for i, f in enumerate(posterior.factors) if target in f.log_factors)
    names = posterior.factors[which].components
    joint = posterior.joint.probabilities(site_name(f"{target}/component", which), f"{target}/cell")
    maps = {}
    for name, each in zip(names, joint, strict=True):
        table = each.reshape(posterior.city.grid.shape)
        p = float(table.sum())
        if p >= _NEGLIGIBLE:
            maps[f"{name} ({percent(p)})"] = table / p
    return maps


def _roses(posterior: Posterior, target: str) -> list[FrameRose]:
    """Return one rose for each ground that has a front, that of its first relation."""
    roses: dict[str, FrameRose] = {}
    for framed in posterior.framed(target):
        ground = framed.term.ground
        if ground in posterior.city and ground not in roses:  # who listens is not on the map
            factor = posterior.factors[framed.which]
            frame_posterior = FramePosterior(posterior.joint, factor, target, framed)
            roses[ground] = FrameRose(ground, *frame_masses(frame_posterior, _DIRECTIONS))
    return list(roses.values())
