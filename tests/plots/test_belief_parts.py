from __future__ import annotations

import numpy as np
import pytest
from plots_fakes import FakePosterior, blob

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.plots import plot_change, plot_relations, plot_sheet, save_figure
from sloop_ppl.plots.belief_parts import bits_gained


def titles(figure) -> list[str]:
    return [ax.get_title() for ax in figure.axes if ax.get_title()]


def test_one_panel_a_part_and_one_for_all(cleveland: CityMap) -> None:
    parts = {f"near {c}": blob(cleveland, 0, 0, 10) for c in "ABC"}
    figure = plot_relations(
        cleveland,
        parts,
        whole=blob(cleveland, 0, 0, 5),
        grounds={"near A": ["HoytBlock"]},
        truth=(10.0, 10.0),
        columns=2,
        title="Why?",
    )
    assert titles(figure) == ["near A", "near B", "near C", "all together"]
    assert figure.get_suptitle() == "Why?"
    assert [len(ax.get_images()) for ax in figure.axes] == [1, 1, 1, 1]


def test_parts_are_each_scaled_to_their_peak(cleveland: CityMap) -> None:
    figure = plot_relations(cleveland, {"a": 7.0 * blob(cleveland, 0, 0, 9)})
    (image,) = figure.axes[0].get_images()
    values = image.get_array()
    assert values is not None
    assert float(values.max()) == 1.0


@pytest.mark.parametrize(
    ("parts", "columns", "message"),
    [
        ({}, 3, "There is no part to draw; expected at least one"),
        ({"a": np.ones((41, 41))}, 0, "columns is 0; expected at least 1"),
        ({"a": np.ones((2, 2))}, 3, r"The part 'a' has shape \(2, 2\)"),
        ({"a": -np.ones((41, 41))}, 3, "The part 'a' has a negative value"),
    ],
)
def test_parts_that_cannot_be_drawn(
    cleveland: CityMap, parts: dict, columns: int, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        plot_relations(cleveland, parts, columns=columns)


def test_bits_gained() -> None:
    uniform, sure = np.full((2, 2), 0.25), np.array([[1.0, 0], [0, 0]])
    assert bits_gained(sure, uniform) == pytest.approx(2)
    assert bits_gained(uniform, uniform) == 0
    assert bits_gained(uniform, sure) == np.inf


def test_a_change_is_blue_where_the_belief_rose(cleveland: CityMap) -> None:
    from matplotlib.figure import Figure

    before, after = blob(cleveland, -50, 0, 15), blob(cleveland, 50, 0, 15)
    ax = plot_change(cleveland, before, after, ax=Figure().add_subplot())
    (image,) = ax.get_images()
    values = np.asarray(image.get_array())
    rose = image.cmap(image.norm(values[cleveland.grid.cell_at(50, 0)]))
    fell = image.cmap(image.norm(values[cleveland.grid.cell_at(-50, 0)]))
    assert rose[2] > rose[0]
    assert fell[0] > fell[2]
    assert ax.get_title().endswith("bits gained")


def test_no_change_can_be_drawn(cleveland: CityMap) -> None:
    from matplotlib.figure import Figure

    same = blob(cleveland, 0, 0, 15)
    ax = plot_change(cleveland, same, same, ax=Figure().add_subplot())
    assert ax.get_title() == "0.00 bits gained"


def test_a_sheet_holds_what_is_given_and_no_more(posterior: FakePosterior, tmp_path) -> None:
    belief = posterior.belief("GreenToyota")
    full = plot_sheet(
        posterior,
        "GreenToyota",
        parts={f"near {c}": belief for c in "ABCD"},
        components={"all": 0.8, "near": 0.2},
        component_prior={"all": 0.6, "near": 0.4},
        influence={"behind A": 1.0},
        truth=(0.0, 0.0),
    )
    assert titles(full) == [
        "GreenToyota",
        *(f"near {c}" for c in "ABCD"),
        "Components",
        "Influence",
        "Front of Velvet Dog",
    ]
    assert save_figure(full, tmp_path / "sheet.png", dpi=50).exists()
    assert titles(plot_sheet(posterior, "RedHonda")) == ["RedHonda"]
    assert titles(plot_sheet(posterior, "RedHonda", components={"all": 1.0})) == [
        "RedHonda",
        "Components",
    ]
