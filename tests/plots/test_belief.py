from __future__ import annotations

import numpy as np
import pytest
import shapely
from matplotlib.figure import Figure
from plots_fakes import FakePosterior, blob

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap
from sloop_ppl.plots import plot_belief, plot_beliefs, save_figure
from sloop_ppl.plots._belief import hpd_region, mode_of, region_outline


def test_the_overlay_lies_where_the_belief_is_with_row_0_in_the_south(cleveland: CityMap) -> None:
    belief = np.zeros(cleveland.grid.shape)
    belief[2, 30] = 1.0
    post = FakePosterior(cleveland, {"Cup": belief}, texts=())
    figure = Figure(figsize=(6, 6), dpi=100)
    ax = plot_belief(post, "Cup", ax=figure.add_subplot(), labels=False, legend=False)
    (image,) = ax.get_images()
    assert image.origin == "lower"
    assert image.get_extent() == [-100, 105, -105, 100]
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    for line in ax.get_lines():
        line.set_visible(False)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[::-1, :, :3].astype(int)

    def darkness(row: int, col: int) -> int:
        x, y = ax.transData.transform(cleveland.grid.centre_of(row, col))
        return 765 - int(pixels[int(y), int(x)].sum())

    assert darkness(2, 30) > 500
    assert darkness(38, 30) < 250
    assert darkness(30, 2) < 250


def test_cells_of_negligible_mass_are_clear(posterior: FakePosterior) -> None:
    ax = plot_belief(posterior, "GreenToyota", ax=Figure().add_subplot())
    values = ax.get_images()[0].get_array()
    assert values is not None
    assert bool(values.mask[40, 40])
    assert not bool(values.mask[5, 11])


def test_hpd_region_holds_the_mass_and_is_the_smallest_that_does() -> None:
    belief = np.array([[0.4, 0.3], [0.2, 0.1]])
    assert hpd_region(belief, 0.4).tolist() == [[True, False], [False, False]]
    assert hpd_region(belief, 0.5).tolist() == [[True, True], [False, False]]
    assert hpd_region(belief, 0.9).tolist() == [[True, True], [True, False]]


def test_hpd_region_takes_ties_together_and_never_a_cell_of_probability_zero() -> None:
    assert hpd_region(np.full((3, 3), 1 / 9), 0.5).all()
    belief = np.zeros((3, 3))
    belief[0, 0] = 1.0
    assert hpd_region(belief, 1.0).sum() == 1


def test_the_outline_of_a_region_follows_its_cells(cleveland: CityMap) -> None:
    region = np.zeros(cleveland.grid.shape, dtype=bool)
    region[0, 0:2] = True
    outline = region_outline(region, cleveland.grid)
    assert outline.length == pytest.approx(2 * (10 + 5))
    assert outline.bounds == (-100, -105, -90, -100)


def test_the_outline_is_the_border_of_the_union_of_the_cells(cleveland: CityMap) -> None:
    grid = cleveland.grid
    region = np.random.default_rng(3).random(grid.shape) < 0.4
    rows, cols = np.nonzero(region)
    x, y = grid.x_m[cols], grid.y_m[rows]
    union = shapely.union_all(shapely.box(x - 2.5, y - 2.5, x + 2.5, y + 2.5))
    outline = region_outline(region, grid)
    assert outline.length == pytest.approx(union.boundary.length)
    assert outline.difference(union.boundary).length == pytest.approx(0, abs=1e-6)


def test_no_cells_have_no_outline(cleveland: CityMap) -> None:
    assert region_outline(np.zeros(cleveland.grid.shape, dtype=bool), cleveland.grid).is_empty


def test_of_equally_probable_cells_the_middle_one_is_the_mode(cleveland: CityMap) -> None:
    assert mode_of(np.ones(cleveland.grid.shape), cleveland.grid) == (2.5, -2.5)


def test_mode_truth_and_legend_say_what_is_drawn(posterior: FakePosterior) -> None:
    ax = plot_belief(posterior, "GreenToyota", ax=Figure().add_subplot(), truth=(-37.5, -72.5))
    places = {line.get_label(): line.get_xydata()[0].tolist() for line in ax.get_lines()}
    assert places == {"most probable cell": [-42.5, -77.5], "true place": [-37.5, -72.5]}
    legend = ax.get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == [
        "50 % HPD region",
        "90 % HPD region",
        "most probable cell",
        "true place",
        "mentioned",
        "mean front of ground",
    ]
    (arrow,) = (a for a in ax.get_children() if a.get_gid() == "frame-arrow")
    (x0, y0), (x1, y1) = arrow._posA_posB  # type: ignore[attr-defined]
    assert (x0, y0) == posterior.city.centroid("VelvetDog")
    assert np.degrees(np.arctan2(y1 - y0, x1 - x0)) == pytest.approx(60)


def test_no_frame_and_no_relation_leave_no_trace_in_the_legend(posterior: FakePosterior) -> None:
    legend = plot_belief(posterior, "RedHonda", ax=Figure().add_subplot()).get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()][-1] == "most probable cell"


def test_all_beliefs_stand_in_one_figure_under_what_was_said(posterior: FakePosterior) -> None:
    figure = plot_beliefs(posterior, truths={"RedHonda": (60.0, 10.0)})
    titles = [ax.get_title() for ax in figure.axes if ax.get_title()]
    assert titles == ["GreenToyota", "RedHonda"]
    assert figure.get_suptitle() == "“It is behind the $5 shop.”"


def test_three_targets_leave_the_fourth_panel_empty(cleveland: CityMap) -> None:
    beliefs = {name: blob(cleveland, 0, 0, 20) for name in "ABC"}
    figure = plot_beliefs(FakePosterior(cleveland, beliefs))
    assert [ax.axison for ax in figure.axes[:4]] == [True, True, True, False]


def test_a_posterior_without_targets_is_refused(cleveland: CityMap) -> None:
    with pytest.raises(InputError, match="The posterior holds no target; describe at least one"):
        plot_beliefs(FakePosterior(cleveland, {}))


def test_an_unknown_target_is_refused(posterior: FakePosterior) -> None:
    with pytest.raises(UnknownName, match=r"Target 'RedHnda' is unknown.*did you mean 'RedHonda'"):
        plot_belief(posterior, "RedHnda")


@pytest.mark.parametrize(
    ("belief", "message"),
    [
        (np.ones((3, 4)) / 12, r"has shape \(3, 4\); expected \(41, 41\), the cells of map"),
        (np.full((41, 41), np.nan), "has a value that is not finite"),
    ],
)
def test_a_belief_that_does_not_fit_the_map_is_refused(
    cleveland: CityMap, belief: np.ndarray, message: str
) -> None:
    with pytest.raises(InputError, match=f"The belief of 'Cup' {message}"):
        plot_belief(FakePosterior(cleveland, {"Cup": belief}), "Cup", ax=Figure().add_subplot())


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_equal_input_gives_equal_bytes(posterior: FakePosterior, tmp_path, ending: str) -> None:
    written = []
    for name in ("a", "b"):
        ax = plot_belief(posterior, "GreenToyota", ax=Figure(figsize=(4, 4)).add_subplot())
        written.append(save_figure(ax, tmp_path / f"{name}.{ending}", dpi=60).read_bytes())
    assert written[0] == written[1]


def test_the_legend_and_the_title_stay_within_the_figure(tmp_path):
    import sloop_ppl as sloop

    city = sloop.load_map("cleveland")
    posterior = sloop.infer("the green toyota is behind velvet dog, near ivy", city, "sloop-m4")
    figure = Figure(figsize=(13, 6), layout="constrained")
    panels = figure.subplots(1, 2)
    for panel in panels:
        plot_belief(posterior, "GreenToyota", ax=panel, title="a model")
    figure.savefig(tmp_path / "compared.png")  # one round of the layout, as a user has it
    width, height = figure.bbox.width, figure.bbox.height
    for panel in panels:
        for drawn in (panel.get_legend(), panel.title):
            box = drawn.get_window_extent()
            assert box.x0 >= 0
            assert box.y0 >= -1
            assert box.x1 <= width
            assert box.y1 <= height + 1
