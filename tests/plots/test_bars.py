from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from sloop_ppl.errors import InputError
from sloop_ppl.plots import plot_components, plot_influence


def names(ax) -> list[str]:
    return [t.get_text() for t in ax.get_yticklabels()]


def test_components_are_drawn_from_the_top_before_and_after() -> None:
    ax = plot_components(
        {"all": 0.7, "near": 0.296, "at": 0.004},
        prior={"at": 0.1, "near": 0.3, "all": 0.6},
        ax=Figure().add_subplot(),
        title="Cup",
    )
    assert names(ax) == ["all", "near", "at"]
    assert ax.yaxis_inverted()
    before, after = ax.containers
    assert [b.get_width() for b in before] == pytest.approx([60, 30, 10])
    assert [b.get_width() for b in after] == pytest.approx([70, 29.6, 0.4])
    assert [t.get_text() for t in ax.texts] == ["60 %", "30 %", "10 %", "70 %", "30 %", "< 1 %"]
    legend = ax.get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == ["before", "after"]


def test_influences_point_both_ways() -> None:
    ax = plot_influence({"behind A": 1.5, "near $B": -0.5}, ax=Figure().add_subplot())
    assert names(ax) == ["behind A", "near $B"]
    first, second = ax.patches
    assert (first.get_width(), second.get_width()) == (1.5, -0.5)
    assert first.get_facecolor() != second.get_facecolor()
    assert [t.get_text() for t in ax.texts] == ["1.50", "−0.50"]
    low, high = ax.get_xlim()
    assert low < -0.5 - 0.2
    assert high > 1.5 + 0.2


def test_influences_that_are_all_zero_can_be_drawn() -> None:
    ax = plot_influence({"near A": 0.0}, ax=Figure().add_subplot())
    assert ax.get_xlim()[0] == 0


@pytest.mark.parametrize(
    ("posterior", "prior", "message"),
    [
        ({}, None, "The posterior is empty; expected at least one number to draw"),
        (
            {"all": 1.2},
            None,
            r"The posterior of 'all' is 1.2; expected a finite number in \[0, 1\]",
        ),
        (
            {"all": 1.0},
            {"near": 1.0},
            "The prior names the components near and the posterior all; expected the same",
        ),
    ],
)
def test_components_that_cannot_be_drawn(posterior: dict, prior: dict, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}$"):
        plot_components(posterior, prior=prior, ax=Figure().add_subplot())


def test_an_influence_that_is_not_finite_is_refused() -> None:
    with pytest.raises(InputError, match="The influence of 'near A' is inf; expected a finite"):
        plot_influence({"near A": float("inf")}, ax=Figure().add_subplot())
