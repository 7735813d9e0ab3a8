from __future__ import annotations

import itertools
from dataclasses import astuple

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from sloop_ppl.plots._palette import (
    ACCENTS,
    CLEAR,
    MUTED,
    TARGET_COLOURS,
    belief_colours,
    difference_colours,
)

# Machado, Oliveira and Fernandes (2009), severity 1.0, on linear RGB.
DEFICIENCIES = {
    "none": np.eye(3),
    "protan": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deutan": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritan": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}


def linear(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(rgb: NDArray[np.float64], seen_as: str = "none") -> NDArray[np.float64]:
    """CIE L*a*b* (D65) of sRGB colours as someone with a colour vision deficiency sees them."""
    seen = np.clip(linear(rgb) @ DEFICIENCIES[seen_as].T, 0, 1)
    to_xyz = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    )
    t = (seen @ to_xyz.T) / np.array([0.95047, 1.0, 1.08883])
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def distance(one: str, other: str, seen_as: str) -> float:
    a, b = (lab(np.array(to_rgb(c)), seen_as) for c in (one, other))
    return float(np.linalg.norm(a - b))


@pytest.mark.parametrize("seen_as", DEFICIENCIES)
@pytest.mark.parametrize("pair", list(itertools.combinations(TARGET_COLOURS[:5], 2)))
def test_target_colours_differ_to_everyone(pair: tuple[str, str], seen_as: str) -> None:
    assert distance(*pair, seen_as) > 15


@pytest.mark.parametrize("seen_as", DEFICIENCIES)
@pytest.mark.parametrize(
    "pair", [("mentioned", "frame"), ("truth", "mode"), ("right", "wrong"), ("frame", "truth")]
)
def test_accents_that_meet_differ_to_everyone(pair: tuple[str, str], seen_as: str) -> None:
    assert distance(ACCENTS[pair[0]], ACCENTS[pair[1]], seen_as) > 15


@pytest.mark.parametrize("seen_as", DEFICIENCIES)
def test_the_lightness_of_belief_falls_evenly(seen_as: str) -> None:
    colours = np.array(belief_colours().colors)
    lightness = lab(colours[:, :3], seen_as)[:, 0]
    steps = -np.diff(lightness)
    assert (steps > -0.05).all()
    if seen_as == "none":
        assert steps.max() < 2.0 * steps.mean()


def test_no_belief_is_clear_and_opacity_only_rises() -> None:
    opacity = np.array(belief_colours().colors)[:, 3]
    assert opacity[0] == 0
    assert (np.diff(opacity) >= 0).all()
    change = np.array(difference_colours().colors)[:, 3]
    assert change[127] == 0
    assert change == pytest.approx(change[::-1])


@pytest.mark.parametrize("palette", [CLEAR, MUTED])
def test_labels_stand_out_from_what_they_stand_on(palette: object) -> None:
    chosen = palette
    assert isinstance(chosen, type(CLEAR))
    for ground in (chosen.ground, chosen.building, chosen.road):
        dark, light = (lab(np.array(to_rgb(c)))[0] for c in (chosen.label, ground))
        assert light - dark > 50
    assert all(to_rgb(colour) for colour in astuple(chosen))
