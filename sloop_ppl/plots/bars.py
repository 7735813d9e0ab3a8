"""Draw small tables of numbers as bars: components before and after, and influences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.plots._axes import fitted, font_pt, new_axes, width_in
from sloop_ppl.plots._palette import ACCENTS, INK, TARGET_COLOURS
from sloop_ppl.plots._protocols import LatentsLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_components", "plot_influence", "plot_latent", "plot_words"]


def plot_components(
    posterior: Mapping[str, float],
    *,
    prior: Mapping[str, float] | None = None,
    ax: Axes | None = None,
    title: str | None = None,
    label: str = "probability of the component (%)",
) -> Axes:
    """Draw the probability of each mixture component, before and after the description.

    Parameters
    ----------
    posterior
        Component -> probability after, in the order they are drawn from the top.
    prior
        Component -> probability before; None to leave it out.
    ax
        Axes to draw on; a new pyplot figure when None.
    title
        Title of the axes.
    label
        What the probabilities are of.

    Returns
    -------
    matplotlib.axes.Axes
        Bars in per cent, the number at the end of each.

    Raises
    ------
    InputError
        When there is nothing to draw, a number is outside [0, 1], or the two do not name the same
        components.
    """
    after = _numbers(posterior, "posterior", low=0.0, high=1.0)
    sets = [("after", after, TARGET_COLOURS[0])]
    if prior is not None:
        before = _numbers(prior, "prior", low=0.0, high=1.0)
        if set(before) != set(after):
            raise InputError(
                f"The prior names the components {', '.join(before)} and the posterior "
                f"{', '.join(after)}; expected the same"
            )
        sets.insert(0, ("before", before, ACCENTS["prior"]))
    axes = new_axes(ax, width=4.4, height=0.7 + 0.42 * len(after))
    size = font_pt(width_in(axes)) + 0.5
    # Bars of one name touch; a fifth of the room is left between names.
    thick = 0.8 / len(sets)
    for k, (when, values, colour) in enumerate(sets):
        at = np.arange(len(after)) + (k - (len(sets) - 1) / 2) * thick
        shares = [100 * values[name] for name in after]
        axes.barh(at, shares, height=0.92 * thick, color=colour, label=when)
        for y, share in zip(at, shares, strict=True):
            text = f"{share:.0f} %" if share >= 1 or share == 0 else "< 1 %"
            _write_at(axes, text, share, y, 2, size)
    # 12 % beyond the longest bar for the number at its end.
    axes.set_xlim(0, 112)
    axes.set_xticks([0, 25, 50, 75, 100])
    _finish(axes, list(after), label, title, size)
    if len(sets) > 1:
        axes.legend(fontsize=size, frameon=False, loc="lower right", labelcolor=INK)
    return axes


def plot_influence(
    bits: Mapping[str, float],
    *,
    ax: Axes | None = None,
    title: str | None = None,
    label: str = "influence of leaving it out (bits)",
) -> Axes:
    """Draw how much each relation moves the belief, in bits.

    Parameters
    ----------
    bits
        Relation in words -> bits, in the order they are drawn from the top; negative ones point to
        the left in another colour.
    ax
        Axes to draw on; a new pyplot figure when None.
    title
        Title of the axes.
    label
        What the bits mean.

    Raises
    ------
    InputError
        When there is nothing to draw or a number is not finite.
    """
    values = _numbers(bits, "influence")
    axes = new_axes(ax, width=4.8, height=0.75 + 0.34 * len(values))
    size = font_pt(width_in(axes)) + 0.5
    colours = [ACCENTS["mentioned" if v >= 0 else "wrong"] for v in values.values()]
    axes.barh(np.arange(len(values)), list(values.values()), height=0.68, color=colours)
    for y, value in enumerate(values.values()):
        text = f"{value:.2f}".replace("-", "−")
        _write_at(axes, text, value, y, 3 if value >= 0 else -3, size)
    axes.axvline(0.0, color=INK, lw=0.8)
    low, high = min(0.0, *values.values()), max(0.0, *values.values())
    room = max(0.25 * (high - low), 0.01)  # for the numbers at the ends
    axes.set_xlim(low - room * (low < 0), high + room)
    _finish(axes, list(values), label, title, size)
    return axes


def _numbers(
    given: Mapping[str, float], what: str, low: float = -np.inf, high: float = np.inf
) -> dict[str, float]:
    """Return the numbers as floats, checked."""
    if not given:
        raise InputError(f"The {what} is empty; expected at least one number to draw")
    values = {str(name): float(value) for name, value in given.items()}
    for name, value in values.items():
        if not np.isfinite(value) or not low - 1e-9 <= value <= high + 1e-9:
            limits = "" if np.isinf(low) else f" in [{low:g}, {high:g}]"
            raise InputError(f"The {what} of '{name}' is {value}; expected a finite number{limits}")
    return values


def _write_at(axes: Axes, text: str, x: float, y: float, off_pt: float, size: float) -> None:
    """Write a number so many points beside the end of its bar, to the left where negative."""
    axes.annotate(
        text, (x, y), xytext=(off_pt, 0), textcoords="offset points", va="center",
        ha="left" if off_pt > 0 else "right", fontsize=size - 0.5, color=INK,
    )  # fmt: skip


def _finish(axes: Axes, names: list[str], label: str, title: str | None, size: float) -> None:
    """Name the bars from the top down and take away what is not needed."""
    style: dict[str, Any] = {"fontsize": size, "color": INK}
    labels = [fitted(name, size, 0.45 * max(width_in(axes), 2.0)) for name in names]
    axes.set_yticks(range(len(names)), labels, parse_math=False, **style)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlabel(label, labelpad=2, **style)
    axes.tick_params(axis="x", labelsize=size - 0.5, length=2.5, width=0.6, labelcolor=INK)
    axes.tick_params(axis="y", length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_linewidth(0.7)
    if title:
        fitted_title = fitted(title, size + 1, width_in(axes))
        axes.set_title(fitted_title, fontsize=size + 1, color=INK, pad=5, parse_math=False)


def plot_latent(posterior: LatentsLike, name: str, *, ax: Axes | None = None) -> Axes:
    """Draw how probable each value of a latent is, before and after what was said.

    Parameters
    ----------
    posterior
        What is believed.
    name
        One of ``posterior.latents``.
    ax
        Axes to draw on; a new pyplot figure when None.

    Returns
    -------
    matplotlib.axes.Axes
        Bars in per cent, the number at the end of each.

    Raises
    ------
    UnknownName
        When the model declares no such latent.
    """
    table = posterior.latent(name)
    values = [str(value) for value in table[name].values]
    after = dict(zip(values, map(float, table.values), strict=True))
    before = dict(zip(values, map(float, table["prior"].values), strict=True))
    return plot_components(
        after, prior=before, ax=ax, title=name, label="probability of the value (%)"
    )


def plot_words(
    words: Mapping[str, float], uttered: str, *, ax: Axes | None = None, title: str | None = None
) -> Axes:
    """Draw how expected each word was, and which one was said.

    Parameters
    ----------
    words
        Word -> probability, as ``PhraseCheck.words`` gives them.
    uttered
        The word that was said; it is drawn in another colour.
    ax
        Axes to draw on; a new pyplot figure when None.
    title
        Title of the axes.

    Returns
    -------
    matplotlib.axes.Axes
        Bars in per cent, the most probable word at the top.

    Raises
    ------
    InputError
        When there is no word, a number is outside [0, 1], or what was said is none of the words.
    """
    shares = _numbers(words, "words", low=0.0, high=1.0)
    if uttered not in shares:
        raise InputError(
            f"'{uttered}' is none of the words {', '.join(shares)}; expected one of them"
        )
    ranked = dict(sorted(shares.items(), key=lambda pair: -pair[1]))
    axes = new_axes(ax, width=4.4, height=0.7 + 0.26 * len(ranked))
    colours = [TARGET_COLOURS[0] if word == uttered else ACCENTS["prior"] for word in ranked]
    axes.barh(np.arange(len(ranked)), [100 * p for p in ranked.values()], color=colours)
    size = font_pt(width_in(axes)) + 0.5
    axes.set_yticks(np.arange(len(ranked)), list(ranked), fontsize=size)
    axes.invert_yaxis()
    axes.set_xlabel("how expected, %", fontsize=size)
    axes.tick_params(axis="x", labelsize=size - 0.5)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if title is not None:
        axes.set_title(title, fontsize=size + 1)
    return axes
