"""The Python of docs/your_own_latent.md runs as it stands, and what the page says is so."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from pyro import poutine

import sloop_ppl as sloop
from sloop_ppl.models import FrameDistribution, Latent, build, preset

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "your_own_latent.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def rows(text):
    return dict(re.findall(r"^\| ([\w ]+) \| ([\d. |]+) \| `\(", text, re.MULTILINE))


def test_a_latent_takes_at_most_twenty_five_lines():
    (code,) = (code for code in BLOCKS if code.startswith("# viewpoint.py\n"))
    assert len([line for line in code.splitlines()[1:] if line.strip()]) <= 25


@pytest.mark.slow
def test_the_page_on_latents_runs(run_page, tmp_path, capsys):
    names = run_page(DOCS / "your_own_latent.md")
    out = capsys.readouterr().out
    assert out.startswith("('viewpoint',)\n")
    assert "('viewpoint',) True" in out  # loaded again
    assert "skip=" in out
    assert (tmp_path / "viewpoint.png").stat().st_size > 30_000
    post, city, model = names["post"], names["city"], names["model"]
    assert float(post.latent("viewpoint").sel(viewpoint="east")) == pytest.approx(0.514, abs=0.005)
    south = city.grid.y_m < city.footprint("VelvetDog").centroid.y
    alone = sloop.infer(sloop.parse("The green toyota is left of Velvet Dog.", city), city, model)
    shares = [float(p.belief("GreenToyota")[south].sum()) for p in (post, alone)]
    assert shares == pytest.approx([0.68, 0.48], abs=0.006)
    shown, printed = rows(PAGE), rows(out)
    assert list(printed) == ["no error", "per relation", "per ground"]
    for name, told in printed.items():
        told, known = ([float(p) for p in row[name].split("|")] for row in (printed, shown))
        assert told == pytest.approx(known, abs=0.006), name
    assert re.findall(r"`(\(.*?\))` \|$", out, re.MULTILINE) == re.findall(
        r"^\| (?:no|per) .* `(\(.*?\))` \|$", PAGE, re.MULTILINE
    )


def test_latents_have_the_sites_that_the_page_says():
    city = sloop.load_map("cleveland", cell_m=20)
    said = sloop.parse("The red bike is near Stone Block.", city)
    told = dict(re.findall(r'^\| `"(\w+)"`.*\| `([\w/]+)`', PAGE, re.MULTILINE))
    assert list(told) == ["speaker", "description", "relation", "ground"]
    for per, site in told.items():
        model = replace(preset("bayes"), latents=(Latent("v", ("a", "b"), (0.3, 0.7), per=per),))
        assert sloop.infer(said, city, model).latents == (site,)


def test_the_page_s_limits_are_those_there_are():
    city = sloop.load_map("cleveland", cell_m=20)
    behind = sloop.parse("The red bike is behind Stone Block.", city)
    which = Latent(
        "which",
        ("StoneBlock", "HoytBlock"),
        (0.5, 0.5),
        given=lambda relation, ground: replace(relation, grounds=(ground,)),
    )
    unsure = replace(preset("bayes"), latents=(which,))
    sites = poutine.trace(build(behind, city, unsure, frames="density")).get_trace().nodes
    assert {"RedBike/frame_0", "RedBike/frame_0/1"} <= set(sites)
    spread = unsure.frame_prior

    def hoyt_faces_east(relation):
        is_point = relation.ground == "HoytBlock"
        return FrameDistribution.points([0.0]) if is_point else spread(relation)

    point = replace(unsure, frame_prior=hoyt_faces_east)
    with pytest.raises(ValueError, match="is a point under some values of another latent"):
        build(behind, city, point, frames="density")()
    twice = sloop.parse("The red bike is near Stone Block and north of Ivy.", city)
    shared = (Latent("v", ("a", "b"), (0.3, 0.7)),)
    with pytest.raises(ValueError, match="use its variant 'paper', or bayes"):
        sloop.infer(twice, city, replace(preset("sloop"), latents=shared))
    paper = replace(preset("sloop", "paper"), latents=shared)
    assert sloop.infer(twice, city, paper).latents == ("v",)
    assert not sloop.infer(twice, city, replace(preset("bayes"), latents=shared)).can_speak
    nine = replace(shared[0], per="ground", support=tuple(range(9)), prior=(1 / 9,) * 9)
    grounds = ("Stone Block", "Hoyt Block", "Velvet Dog", "Ivy")
    text = ", ".join(f"near {g}, beside {g}" for g in grounds)
    four = sloop.parse(f"The red bike is {text}.", city)
    assert len(four.relations) == 8
    with pytest.raises(ValueError, match="at most 5184"):
        sloop.infer(four, city, replace(preset("bayes"), latents=(nine,)))


def test_every_link_of_the_page_leads_somewhere():
    links = re.findall(r"\]\((?!http)([^)]+)\)", PAGE)
    assert links
    for link in links:
        file, _, part = link.partition("#")
        text = (DOCS / file).read_text() if file.endswith(".md") else PAGE if not file else ""
        assert not file or (DOCS / file).exists(), link
        headings = [
            h.lower().replace(" ", "-") for h in re.findall(r"^#+ (.*)$", text, re.MULTILINE)
        ]
        assert not part or part in headings, link
