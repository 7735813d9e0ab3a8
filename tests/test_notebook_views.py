"""What a notebook shows of a value: a short line, and a small piece of HTML without script."""

from __future__ import annotations

from xml.dom import minidom

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl._html import html_table, svg_map
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import bundled_examples, score_beliefs
from sloop_ppl.models import preset
from sloop_ppl.planning import SearchConfig, run_search

TEXT = "the green toyota is behind velvet dog"


@pytest.fixture(scope="module")
def values():
    city = sloop.load_map("cleveland")
    said = sloop.parse(TEXT, city)
    post = sloop.infer(said, city)
    table = {t: post.belief(t) for t in post.targets}
    places = {"GreenToyota": (-47.5, -62.5)}
    episode = run_search(
        table, city, places, config=SearchConfig(sims=50), rng=np.random.default_rng(0)
    )
    models = {name: preset(name) for name in ("uniform", "sloop")}
    quality = score_beliefs(bundled_examples()[:2], models, rng=np.random.default_rng(0))
    other = sloop.infer(said, city, model="sloop")
    return {
        "city": city,
        "description": said,
        "posterior": post,
        "episode": episode,
        "quality": quality,
        "comparison": post.compare(other),
    }


NAMES = ["city", "description", "posterior", "episode", "quality", "comparison"]


@pytest.mark.parametrize("name", NAMES)
def test_it_is_well_formed_small_and_runs_nothing(values, name):
    html = values[name]._repr_html_()
    found = minidom.parseString(f"<div>{html}</div>")
    tags = {node.tagName for node in found.getElementsByTagName("*")}
    assert not tags & {"script", "style", "link", "img", "iframe"}
    assert not any(
        a.startswith("on")
        for e in found.getElementsByTagName("*")
        for a in dict(e.attributes.items())
    )
    assert len(html) < 400_000
    assert tags & {"table", "svg"}


@pytest.mark.parametrize("name", NAMES)
def test_its_line_is_short(values, name):
    line = repr(values[name])
    assert "\n" not in line
    assert len(line) < 240


def test_what_was_said_cannot_become_markup(values):
    city = values["city"]
    said = sloop.parse("the green toyota is behind velvet dog <script>alert(1)</script>", city)
    assert "<script>" not in said._repr_html_()
    assert "&lt;b&gt;" in html_table([("<b>", 1)])


def test_a_large_table_is_drawn_by_blocks_and_keeps_its_sum():
    heat = np.zeros((400, 400))
    heat[399, 0] = 1.0  # the north-west corner
    drawing = minidom.parseString(svg_map((0, 0, 2000, 2000), heat=heat))
    cells = drawing.getElementsByTagName("rect")[1:]
    assert len(cells) == 1
    assert float(cells[0].getAttribute("x")) == 0
    assert float(cells[0].getAttribute("y")) == pytest.approx(0, abs=0.2)


def test_posteriors_are_compared_target_by_target(values):
    post, city = values["posterior"], values["city"]
    same = post.compare(post)
    assert same.total_variation == {"GreenToyota": 0.0}
    assert same.kl_nats == {"GreenToyota": 0.0}
    compared = values["comparison"]
    a, b = compared.beliefs["GreenToyota"]
    assert compared.total_variation["GreenToyota"] == pytest.approx(np.maximum(b - a, 0).sum())
    assert compared.kl_nats["GreenToyota"] == pytest.approx((a * np.log(a / b)).sum())
    assert compared.difference("GreenToyota").sum() == pytest.approx(0, abs=1e-12)
    assert compared.labels == ("bayes", "sloop")
    with pytest.raises(UnknownName, match="Bus"):
        compared.difference("Bus")
    bike = sloop.infer("the red bike is near ivy", city)
    with pytest.raises(InputError, match="no target in common"):
        post.compare(bike)
    with pytest.raises(InputError, match="expected the same cells"):
        post.compare(sloop.infer(TEXT, sloop.load_map("cleveland", cell_m=10)))
    with pytest.raises(InputError, match="expected a Posterior"):
        post.compare("sloop")
