"""Names in scripts that the usual font lacks: another font has them, or one line says which."""

from __future__ import annotations

import dataclasses
import logging
import warnings

import matplotlib as mpl
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sloop_ppl.maps import load_map
from sloop_ppl.plots import plot_map, save_figure
from sloop_ppl.plots._glyphs import _fonts_with, collected_glyphs

KANJI = "青い花"


def test_a_map_of_names_without_glyphs_gives_one_line(tmp_path, caplog):
    if _fonts_with(set(KANJI)):
        pytest.skip("a font here has kanji")
    city = load_map("cleveland")
    named = tuple(dataclasses.replace(m, name=f"{KANJI}{i}") for i, m in enumerate(city.landmarks))
    with caplog.at_level(logging.WARNING):
        save_figure(plot_map(dataclasses.replace(city, landmarks=named)), tmp_path / "map.png")
    (record,) = caplog.records
    assert record.getMessage() == (
        f"Figure '{tmp_path / 'map.png'}': no installed font has 3 of its letters, drawn as boxes: "
        "い 花 青; install one that has, such as Noto Sans CJK"
    )


def test_letters_are_taken_from_another_font_that_has_them(tmp_path, caplog):
    # DejaVu Sans has Armenian, STIX has not.
    with mpl.rc_context({"font.family": ["STIXGeneral"]}), caplog.at_level(logging.WARNING):
        figure = Figure(figsize=(2, 1))
        text = figure.text(0.1, 0.5, "Երևան")
        with collected_glyphs() as missing:
            FigureCanvasAgg(figure).draw()
        assert missing == set("Երևան")
        save_figure(figure, tmp_path / "a.png")
    assert text.get_fontfamily() == ["STIXGeneral", *_fonts_with(missing)]
    assert not caplog.records


def test_other_warnings_are_given_on():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with collected_glyphs() as missing:
            warnings.warn("Glyph 38738 missing from font(s) DejaVu Sans.", stacklevel=1)
            warnings.warn("something else", stacklevel=1)
    assert missing == {"青"}
    assert [str(warning.message) for warning in caught] == ["something else"]


def test_the_fewest_fonts_are_taken():
    assert len(_fonts_with({"a", "b"})) == 1
