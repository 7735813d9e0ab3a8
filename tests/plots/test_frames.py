"""Roses on all buildings of a map, and boxes of deviations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import load_map
from sloop_ppl.models.frames import FrameDistribution, FramePart, context_image
from sloop_ppl.plots.context import plot_context
from sloop_ppl.plots.deviations import draw_deviations, plot_deviations
from sloop_ppl.plots.frame import plot_frames

NORTH = FrameDistribution((FramePart(math.pi / 2, 50.0, 0.9),), lapse=0.1)


def axes():
    return Figure().subplots()


def roses(ax):
    return [patch for patch in ax.patches if patch.get_gid() == "front"]


def test_a_rose_points_where_its_building_faces():
    city = load_map("cleveland")
    ax = plot_frames(city, {"BallBuilding": NORTH}, ax=axes())
    (rose,) = roses(ax)
    x, y = city.centroid("BallBuilding")
    far = rose.get_path().vertices - (x, y)
    tip = far[np.hypot(*far.T).argmax()]
    assert math.atan2(tip[1], tip[0]) == pytest.approx(math.pi / 2, abs=math.radians(6))


def test_every_building_that_is_given_gets_a_rose():
    city = load_map("cleveland")
    frames = {b.id: NORTH for b in city.of_kind("building")[:5]}
    assert len(roses(plot_frames(city, frames, ax=axes()))) == 5
    with pytest.raises(UnknownName):
        plot_frames(city, {"Nowhere": NORTH}, ax=axes())


def test_boxes_are_drawn_in_order_with_their_numbers():
    ax = plot_deviations({"EGO-CTX": [0.0, 1.0, 90.0], "Random": [80.0, 100.0]}, ax=axes())
    assert [t.get_text() for t in ax.get_yticklabels()] == ["EGO-CTX (3)", "Random (2)"]
    assert "degrees" in ax.get_xlabel()
    with pytest.raises(InputError, match="There are no deviations to draw"):
        plot_deviations({"EGO": []}, ax=axes())


def test_the_row_in_place_of_people_is_labelled_as_such():
    figure = draw_deviations({"EGO": [1.0, 2.0]}, [3.0])
    left, right = figure.axes
    assert "not reproducible" in left.texts[0].get_text()
    assert "in place of Human" in right.get_yticklabels()[-1].get_text()
    assert len(draw_deviations({"EGO": [1.0, 2.0]}, []).axes[1].get_yticklabels()) == 1


def test_a_picture_is_drawn_with_south_at_the_bottom_and_its_front():
    city = load_map("cleveland")
    image = context_image(city, "BallBuilding")
    ax = plot_context(image, frame_angle_rad=math.pi / 2, title="EGO-CTX", ax=axes())
    assert ax.images[0].origin == "lower"
    np.testing.assert_array_equal(ax.images[0].get_array(), image)
    (arrow,) = ax.texts
    assert arrow.xy[0] == pytest.approx(arrow.xyann[0])
    assert arrow.xy[1] > arrow.xyann[1]
    assert ax.get_title() == "EGO-CTX"
    with pytest.raises(InputError, match="The picture has shape"):
        plot_context(np.full((2, 2), np.nan), ax=axes())
