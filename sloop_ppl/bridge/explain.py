"""Say in words why a belief is where it is, and what would move it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import shapely

from sloop_ppl.bridge._formatting import unlocated_line
from sloop_ppl.bridge.relation_text import (
    facing,
    ground_label,
    meant_lines,
    names_of,
    percent,
    reading_lines,
    relations_in_words,
)
from sloop_ppl.inference import hpd_places, mode_m, modes_of
from sloop_ppl.maps._whereabouts import whereabouts

if TYPE_CHECKING:
    import xarray

    from sloop_ppl.inference import Influence, Posterior

__all__ = ["explain_lines"]

# Within this of a place counts as at the place, and moves beyond it as moves: three cells of 5 m.
_NEAR_M = 15.0
# Factor by which the probability of a lapse must have grown to be worth a line.
_SUSPECT = 1.5
# A prior probability from which a front is taken as certain.
_CERTAIN = 1 - 1e-9
_MOST_PLACES = 3
# Tail probability below which a word is called surprising.
_SURPRISING = 0.1


def explain_lines(posterior: Posterior, rng: np.random.Generator | None = None) -> list[str]:
    """Return lines that explain the belief of every target.

    Where the mass is; how many bits each phrase is worth; which component, which places and which
    front the belief rests on; which phrase or front, if it were otherwise, would move it; and
    which reading of what was said it takes.

    Parameters
    ----------
    posterior
        What is believed.
    rng
        Wanted by engines that draw.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> lines = explain_lines(sloop.infer("The red bike is near Ivy.", "cleveland"))
    >>> lines[0]
    'RedBike'
    """
    lines = []
    for target in posterior.targets:
        lines.append(f"{target}")
        lines += [f"  {line}" for line in _where(posterior, target)]
        if not posterior.relations(target):
            lines.append(f"  {unlocated_line(posterior, target)}")
            continue
        lines += [f"  {line}" for line in _why(posterior, target, rng)]
    return [*lines, *reading_lines(posterior)]


def _where(posterior: Posterior, target: str) -> Iterator[str]:
    city, mode, name_of = posterior.city, posterior.mode(target), names_of(posterior).of
    near = posterior.probability_in(target, shapely.Point(mode).buffer(_NEAR_M))
    yield (
        f"where: most probably {whereabouts(city, *mode, name_of)}; {percent(near)} within "
        f"{_NEAR_M:g} m of that"
    )
    places = hpd_places(posterior.belief(target), city.grid, 0.9)
    if len(places) == 1:
        yield f"  90 % in one place of {_area(posterior, places[0].cells)}"
        return
    yield f"  90 % in {len(places)} places:"
    for place in places[:_MOST_PLACES]:
        yield (
            f"    {percent(place.p)} {whereabouts(city, *place.mode_m, name_of)} "
            f"({_area(posterior, place.cells)})"
        )


def _why(posterior: Posterior, target: str, rng: np.random.Generator | None) -> Iterator[str]:
    words = relations_in_words(posterior, target)
    influences = sorted(posterior.influence(target, rng), key=lambda i: -i.bits)
    yield "phrases, by how much the belief owes to each:"
    for influence in influences:
        yield f"  {influence.bits:.2f} bits  “{words[influence.index]}”"
    for lapse in posterior.lapses(target):
        if lapse.p > max(_SUSPECT * lapse.prior, 0.0):
            was = percent(lapse.prior)
            yield f"perhaps wrong: “{words[lapse.index]}”, {percent(lapse.p)} (was {was})"
    yield from _surprises(posterior, target, words)
    components, prior = posterior.component(target), posterior.component_prior(target)
    if len(components) > 1:
        components_text = ", ".join(
            f"{name} {percent(p)} (was {percent(prior[name])})"
            for name, p in components.items()
            if prior[name]
        )
        yield f"read as: {components_text}"
    for line in meant_lines(posterior, target):
        yield f"meant by {line}"
    yield from _frames(posterior, target)
    yield from _latents(posterior)
    yield "what would change it:"
    changes = list(_changes(posterior, target, influences, words))
    yield from changes or ["  no phrase by itself, and no front"]


def _frames(posterior: Posterior, target: str) -> Iterator[str]:
    names = names_of(posterior)
    for framed in posterior.framed(target):
        if framed.term.each:  # "not behind a bank": no one front to tell of
            continue
        frame = posterior.frame(target, framed.term.ground, framed.relation)
        angles, prior = frame["angle"].values, frame["prior"].values
        modes = modes_of(frame.values, angles)
        label = ground_label(names, framed.term.ground)
        directions = []
        for mean, _ in modes:
            # cos(45 degrees) = sqrt(1 / 2): an eighth of a turn to either side.
            near = np.cos(angles - mean) >= math.sqrt(0.5) - 1e-9
            before, after = float(prior[near].sum()), float(frame.values[near].sum())
            sure = f"{percent(after)} within 45° of that (was {percent(before)})"
            certain = before > _CERTAIN and len(modes) == 1
            directions.append(
                f"{facing(mean)} ({math.degrees(mean) % 360:.0f}° from east), "
                f"{'taken as certain' if certain else sure}"
            )
        yield f"front: “{framed.term.relation}” takes {label} to face {'; or '.join(directions)}"


def _surprises(posterior: Posterior, target: str, words: tuple[str, ...]) -> Iterator[str]:
    """Tell of phrases that were hardly to be expected, given the others."""
    if len(words) < 2 or not posterior.can_speak:
        return
    for check in posterior.predictive(target):
        if check.tail < _SURPRISING and not check.relation.negated:
            word, most = max(check.words.items(), key=lambda pair: pair[1])
            yield (
                f"surprising: “{words[check.index]}”, {percent(check.p)} given the rest, word "
                f"{check.rank} of {len(check.words)}; “{word}” had {percent(most)}"
            )


def _latents(posterior: Posterior) -> Iterator[str]:
    """Tell the values of declared latents that became more probable than they were."""
    for name in posterior.latents:
        table = posterior.latent(name)
        shares = zip(table[name].values, table.values, table["prior"].values, strict=True)
        ranked = sorted(shares, key=lambda share: -share[1])[:_MOST_PLACES]
        values_text = ", ".join(
            f"{value} {percent(p)} (was {percent(q)})" for value, p, q in ranked
        )
        yield f"{name}: {values_text}"


def _changes(
    posterior: Posterior, target: str, influences: list[Influence], words: tuple[str, ...]
) -> Iterator[str]:
    """Tell of the phrases and fronts that would move the most probable cell by over 15 m."""
    city, mode, names = posterior.city, posterior.mode(target), names_of(posterior)
    for influence in influences if len(influences) > 1 else []:
        other = mode_m(influence.without, city.grid)
        if math.dist(mode, other) > _NEAR_M:
            yield (
                f"  without “{words[influence.index]}”: most probably "
                f"{whereabouts(city, *other, names.of)}, {math.dist(mode, other):.0f} m away"
            )
    for framed in posterior.framed(target):
        table = posterior.joint_frame(target, framed.relation, framed.term.ground)
        mean = _mean(table.sum(("y", "x")))
        # The quarter turn about the direction opposite to the mean.
        opposite = table[np.cos(table["angle"].values - mean) <= -math.sqrt(0.5)].sum("angle")
        if float(opposite.sum()) < 1e-6:
            continue
        other = mode_m(opposite.values, city.grid)
        if math.dist(mode, other) > _NEAR_M:
            label = ground_label(names, framed.term.ground)
            yield (
                f"  if {label} faced {facing(mean + math.pi)}: most probably "
                f"{whereabouts(city, *other, names.of)}, {math.dist(mode, other):.0f} m away"
            )


def _mean(frame: xarray.DataArray) -> float:
    """Return the circular mean of a distribution over directions, radians."""
    angle = frame["angle"].values
    return math.atan2(float(frame.values @ np.sin(angle)), float(frame.values @ np.cos(angle)))


def _area(posterior: Posterior, cells: int) -> str:
    return f"{cells * posterior.city.grid.cell_m**2:,.0f} m2"
