"""The picture of streets, crossings and blocks."""

from __future__ import annotations

import itertools

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sloop_ppl.maps import bundled_maps, load_map, street_network
from sloop_ppl.plots import plot_blocks
from sloop_ppl.plots._labels import LabelLayer
from tests.streets import city, house, two_by_two


def drawn(city):
    figure = Figure(figsize=(6.6, 6.8), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    assert plot_blocks(city, ax=ax) is ax
    canvas.draw()
    (layer,) = (a for a in ax.get_children() if isinstance(a, LabelLayer))
    return ax, layer.place(canvas.get_renderer())


def test_blocks_are_numbered_in_their_middle_and_streets_named():
    ax, placed = drawn(two_by_two())
    numbers = {text.get_text(): text.get_position() for text in ax.texts if text.get_text()}
    network = street_network(two_by_two())
    assert {str(block.number) for block in network.blocks} <= set(numbers)
    (middle,) = (block for block in network.blocks if not block.cut)
    assert numbers[str(middle.number)] == pytest.approx((0, 0), abs=1)
    assert {p.label.text for p in placed} == {"South St", "North St", "West Ave", "East Ave"}


def test_neighbouring_blocks_have_different_tints():
    from sloop_ppl.plots.blocks import _tints

    blocks = street_network(two_by_two()).blocks
    tints = _tints(blocks)
    for (one, a), (other, b) in itertools.combinations(zip(blocks, tints, strict=True), 2):
        assert a != b or not one.polygon.intersects(other.polygon)


def test_corners_are_marked_and_the_legend_names_what_there_is():
    ax, _ = drawn(two_by_two())
    marks = [len(c.get_offsets()) for c in ax.collections]
    assert marks == [4]
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["street axis", "corner", "block and its number"]


@pytest.mark.parametrize("name", bundled_maps())
def test_bundled_maps_are_drawn_without_overlaps(name):
    _, placed = drawn(load_map(name))
    for one, other in itertools.combinations(placed, 2):
        assert not one.box.intersects(other.box)


def test_a_map_without_streets_is_drawn_too():
    ax, placed = drawn(city(house("House", 0, 0)))
    assert placed == ()
    assert ax.get_legend() is None
