from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from plots_fakes import Frame

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.plots import frame_bins, plot_frame
from sloop_ppl.plots._frame_arrows import circular_sd_rad
from sloop_ppl.plots.frame import _petals


def test_bins_follow_the_von_mises_and_sum_to_one() -> None:
    bins = frame_bins([Frame("A", "front", math.radians(90), 3.0)], 360)
    angles = 2 * math.pi * np.arange(360) / 360
    assert bins.sum() == pytest.approx(1)
    assert bins.argmax() == 90
    mean = np.angle((bins * np.exp(1j * angles)).sum())
    assert mean == pytest.approx(math.pi / 2)
    resultant = abs((bins * np.exp(1j * angles)).sum())
    assert resultant == pytest.approx(0.8099855, abs=1e-5)  # I1(3) / I0(3)


def test_what_is_missing_to_one_is_uniform() -> None:
    bins = frame_bins([Frame("A", "front", 0.0, None, p=0.75)], 72)
    assert bins[36] == pytest.approx(0.25 / 72, rel=1e-6)
    assert frame_bins([], 8).tolist() == [0.125] * 8


def test_two_parts_weigh_as_their_p() -> None:
    parts = [Frame("A", "front", 0.0, 80.0, 0.3), Frame("A", "front", math.pi, 80.0, 0.7)]
    bins = frame_bins(parts, 72)
    assert bins[27:46].sum() == pytest.approx(0.7, abs=1e-6)


def test_the_spread_of_a_direction() -> None:
    assert circular_sd_rad(None) == 0
    assert circular_sd_rad(0.0) == pytest.approx(math.pi / 2)
    assert circular_sd_rad(1e4) == pytest.approx(0.01, rel=1e-3)
    assert circular_sd_rad(1e-300) == pytest.approx(math.pi / 2)


def test_the_area_of_a_petal_is_its_probability() -> None:
    bins = np.array([0.5, 0.25, 0.25, 0.0])
    radii = np.sqrt(bins * 4)
    points = _petals(0.0, 0.0, radii)
    assert np.hypot(*points.T).max() == pytest.approx(math.sqrt(2))
    assert (radii**2 / (radii**2).sum()).tolist() == pytest.approx(bins.tolist())


def test_the_rose_lies_on_its_landmark_and_points_the_right_way(cleveland: CityMap) -> None:
    bins = np.zeros(8)
    bins[2] = 1.0  # north
    ax = plot_frame(cleveland, "HoytBlock", bins, ax=Figure().add_subplot())
    x, y = cleveland.centroid("HoytBlock")
    (rose,) = (p for p in ax.patches if p.get_zorder() == 4.0)
    middle = np.asarray(rose.get_path().vertices).mean(axis=0)
    assert middle[0] == pytest.approx(x, abs=1)
    assert middle[1] > y + 2
    west, east = ax.get_xlim()
    assert (west + east) / 2 == pytest.approx(x)
    assert ax.get_title() == "Front of Hoyt Block"


def test_the_prior_is_an_outline_in_the_legend(cleveland: CityMap) -> None:
    ax = plot_frame(cleveland, "HoytBlock", np.ones(8), prior=np.ones(8), ax=Figure().add_subplot())
    legend = ax.get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == ["posterior", "prior"]


@pytest.mark.parametrize(
    ("bins", "message"),
    [
        (np.array([0.5, -0.5]), r"The posterior of the frame has shape \(2,\); expected"),
        (np.ones((2, 2)), r"has shape \(2, 2\); expected probabilities of equal directions"),
        (np.array([np.nan, 1.0]), "finite and none negative"),
        (np.zeros(4), "The posterior of the frame is zero everywhere"),
    ],
)
def test_bad_bins_are_refused(cleveland: CityMap, bins: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        plot_frame(cleveland, "HoytBlock", bins, ax=Figure().add_subplot())
