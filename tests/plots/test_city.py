from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sloop_ppl.errors import UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark, bundled_maps, load_map
from sloop_ppl.plots import plot_map
from sloop_ppl.plots._labels import LabelLayer, Placed


def drawn(city: CityMap, width: float, **style: object) -> tuple[Figure, tuple[Placed, ...]]:
    figure = Figure(figsize=(width, width * 1.1), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    assert plot_map(city, ax=ax, **style) is ax
    canvas.draw()
    (layer,) = (a for a in ax.get_children() if isinstance(a, LabelLayer))
    return figure, layer.place(canvas.get_renderer())


@pytest.mark.parametrize("width", [3.4, 7.0])
@pytest.mark.parametrize("name", bundled_maps())
def test_labels_neither_overlap_nor_leave_the_axes(name: str, width: float) -> None:
    figure, placed = drawn(load_map(name), width)
    assert len(placed) >= 8
    window = shapely.box(*figure.axes[0].bbox.extents)
    for label in placed:
        assert window.contains(label.box), label.label.text
    for one, other in itertools.combinations(placed, 2):
        assert not one.box.intersects(other.box), (one.label.text, other.label.text)


def test_labels_move_with_their_axes(cleveland: CityMap) -> None:
    figure = Figure(figsize=(5, 5))
    canvas = FigureCanvasAgg(figure)
    ax = plot_map(cleveland, ax=figure.add_axes((0.1, 0.1, 0.8, 0.8)), legend=False)
    (layer,) = (a for a in ax.get_children() if isinstance(a, LabelLayer))
    canvas.draw()
    before = [p.box.centroid.coords[0] for p in layer.place(canvas.get_renderer())]
    ax.set_position((0.15, 0.05, 0.8, 0.8))
    canvas.draw()
    placed = layer.place(canvas.get_renderer())
    after = [p.box.centroid.coords[0] for p in placed]
    assert np.subtract(after, before) == pytest.approx(np.tile([25.0, -25.0], (len(after), 1)))
    assert placed[0].text.get_position() == pytest.approx(after[0])


def test_a_wide_map_carries_more_names_than_a_narrow_one(cleveland: CityMap) -> None:
    assert len(drawn(cleveland, 7.0)[1]) > len(drawn(cleveland, 2.5)[1])


def test_labels_are_of_readable_size(cleveland: CityMap) -> None:
    for width, least in ((3.4, 4.0), (7.0, 5.4)):
        assert min(p.text.get_fontsize() for p in drawn(cleveland, width)[1]) > least


def test_street_names_run_along_their_streets(cleveland: CityMap) -> None:
    placed = {p.label.text: p for p in drawn(cleveland, 7.0)[1]}
    assert placed["West 6th Street"].text.get_rotation() % 180 == pytest.approx(120, abs=6)
    assert placed["West Saint Clair Avenue"].text.get_rotation() % 180 == pytest.approx(33, abs=6)
    assert placed["Stone Block"].text.get_rotation() == 0


def test_every_landmark_to_highlight_is_named_even_a_nameless_one(cleveland: CityMap) -> None:
    wanted = ["ParkingLot5", "InsomniaCookies", "JohnsonCourt"]
    placed = drawn(cleveland, 3.4, highlight=wanted)[1]
    assert [p.label.text for p in placed[:3]] == [
        "Parking Lot 5",
        "Insomnia Cookies",
        "Johnson Court",
    ]


def test_an_unknown_landmark_to_highlight_is_named_in_the_error(cleveland: CityMap) -> None:
    with pytest.raises(UnknownName, match="Landmark of map cleveland 'VelvetDgo' is unknown"):
        plot_map(cleveland, ax=Figure().add_subplot(), highlight=["VelvetDgo"])


def test_limits_are_the_extent_and_with_a_grid_the_cells(cleveland: CityMap) -> None:
    plain, gridded = (
        plot_map(cleveland, ax=Figure().add_subplot(), labels=False, grid=grid)
        for grid in (False, True)
    )
    assert (*plain.get_xlim(), *plain.get_ylim()) == (-100, 100, -100, 100)
    assert (*gridded.get_xlim(), *gridded.get_ylim()) == (-100, 105, -105, 100)
    assert plain.get_aspect() == 1
    assert "(m)" in plain.get_xlabel()
    assert "(m)" in plain.get_ylabel()


def test_labels_false_places_none(cleveland: CityMap) -> None:
    assert drawn(cleveland, 5.0, labels=False)[1] == ()


def test_a_pyplot_figure_is_made_only_when_no_axes_is_given(cleveland: CityMap) -> None:
    from matplotlib import pyplot as plt

    before = plt.get_fignums()
    plot_map(cleveland, ax=Figure().add_subplot())
    assert plt.get_fignums() == before
    ax = plot_map(cleveland)
    assert len(plt.get_fignums()) == len(before) + 1
    plt.close(ax.get_figure(root=True))


def test_every_geometry_of_every_kind_can_be_drawn() -> None:
    square = shapely.box(-8, -8, 8, 8)
    holed = square.difference(shapely.box(-2, -2, 2, 2))
    shapes = [
        shapely.Point(1, 2),
        shapely.LineString([(-30, -20), (30, 25)]),
        shapely.MultiLineString([[(-30, 0), (0, 0)], [(5, 5), (30, 5)]]),
        holed,
        shapely.MultiPolygon([square, shapely.box(12, 12, 20, 18)]),
        shapely.MultiPoint([(3, 3), (9, 9)]),
    ]
    kinds = ("building", "street", "service", "pedestrian", "parking", "park", "water", "square")
    marks = tuple(
        Landmark(f"{kind}{i}", kind, shape, name=f"Costs ${i} and $5")
        for kind in (*kinds, "poi")
        for i, shape in enumerate(shapes)
    )
    city = CityMap("all", Grid.square(40.0), marks)
    ids = [m.id for m in marks]
    figure, placed = drawn(city, 5.0, highlight=ids)
    assert placed
    assert figure.axes[0].get_xlim() == (-40, 40)


def test_a_map_without_landmarks_is_drawn_empty() -> None:
    assert drawn(CityMap("empty", Grid.square(40.0), ()), 4.0)[1] == ()
