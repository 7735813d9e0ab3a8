"""The gallery has every plot of the package, and its page is what the script writes."""

from __future__ import annotations

import importlib.util
import sys

import pytest
from support.tree import ROOT

from sloop_ppl import plots

_SPEC = importlib.util.spec_from_file_location("gallery", ROOT / "examples" / "gallery.py")
gallery = importlib.util.module_from_spec(_SPEC)
sys.modules[_SPEC.name] = gallery
_SPEC.loader.exec_module(gallery)
FOLDER = ROOT / "docs" / "images" / "gallery"
# Drawn by other tests, and slow.
SLOW = {"film", "sheet", "one_sheet", "search"}


def test_every_plot_is_in_it():
    drawn = {name for name in plots.__all__ if name.startswith(("plot_", "draw_", "animate_"))}
    assert set(gallery.DRAWN.values()) == drawn, "add a function to examples/gallery.py"


def test_the_page_is_up_to_date():
    assert (ROOT / "docs" / "gallery.md").read_text() == gallery.page(), "run make gallery"


@pytest.mark.parametrize("draw", gallery.DRAWN, ids=lambda draw: draw.__name__)
def test_each_has_a_picture_and_a_thumbnail(draw):
    assert (FOLDER / gallery.file_of(draw)).stat().st_size > 1_000
    assert 500 < (FOLDER / "thumbs" / f"{draw.__name__}.png").stat().st_size < 150_000


@pytest.mark.parametrize(
    "draw", [d for d in gallery.DRAWN if d.__name__ not in SLOW], ids=lambda d: d.__name__
)
def test_each_can_be_drawn(draw, tmp_path):
    import matplotlib.pyplot as plt

    draw(tmp_path / gallery.file_of(draw))
    plt.close("all")
    assert (tmp_path / gallery.file_of(draw)).stat().st_size > 2_000
