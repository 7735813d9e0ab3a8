"""The page of its own, opened from the disk with the network cut."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.cli import main
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.web import write_page

pytestmark = pytest.mark.xdist_group("chromium")

TEXT = "the green toyota is in front of hoyt block"
PLACE = {"GreenToyota": (27.5, -67.5)}


@pytest.fixture
def open_file(browser):
    """Return a function that opens a file without a network; nothing may have been asked for."""
    contexts, faults = [], []

    def note(url):
        if not url.startswith(("file:", "data:")):
            faults.append(url)

    def opened(path, **options):
        context = browser.new_context(offline=True, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
        page.on(
            "request",
            lambda r: None if r.url.startswith(("file:", "data:")) else faults.append(r.url),
        )
        page.goto(path.as_uri())
        page.locator("svg.map .belief image").wait_for(state="attached")
        return page

    yield opened
    for context in contexts:
        context.close()
    assert faults == []


def test_a_search_is_played_from_a_file(open_file, tmp_path, capsys):
    path = tmp_path / "search.html"
    with pytest.raises(SystemExit) as end:
        main(["search", TEXT, "--map", "cleveland", "--place", "GreenToyota=27.5,-67.5",
              "--html", str(path), "--json"])  # fmt: skip
    assert end.value.code == 0
    report = json.loads(capsys.readouterr().out)
    page = open_file(path)
    slider = page.get_by_label("Step of the search")
    assert int(slider.get_attribute("max")) == report["steps"]
    page.get_by_role("button", name="Play").click()
    page.locator(".step-line", has_text=re.compile("Step [2-9]")).wait_for()
    slider.fill(str(report["steps"]))
    assert page.inner_text(".step-line").endswith("Found so far: GreenToyota. Found.")
    flown = page.locator(".path .flown:not(.halo)").get_attribute("d")
    points = [[float(x), -float(y)] for x, y in re.findall(r"[ML](\S+) (\S+?)(?=[ML]|$)", flown)]
    assert points == [pose[:2] for pose in report["poses"]]


def test_a_belief_is_shown_from_a_file(open_file, tmp_path):
    path = tmp_path / "belief.html"
    text = f"{TEXT}, and the red bike is near ivy"
    with pytest.raises(SystemExit) as end:
        main(["infer", text, "--map", "cleveland", "--html", str(path)])
    assert end.value.code == 0
    page = open_file(path)
    assert page.inner_text(".said") == f"“{text}”"
    assert "GreenToyota:" in page.inner_text(".live")
    page.get_by_role("button", name="RedBike").click()
    assert "RedBike:" in page.inner_text(".live")
    posterior = sloop.infer(text, "cleveland")
    x, y = posterior.mode("RedBike")
    at = page.evaluate(
        """([x, y]) => { const p = new DOMPoint(x, -y).matrixTransform(
            document.querySelector("svg.map").getScreenCTM()); return [p.x, p.y]; }""",
        [x, y],
    )
    page.mouse.move(*at)
    shown = float(page.inner_text(".readout").replace("%", ""))
    assert shown == pytest.approx(100 * posterior.belief("RedBike").max(), rel=0.06)


def test_texts_and_names_are_no_markup(open_file, tmp_path):
    from dataclasses import replace

    city = sloop.load_map("cleveland")
    evil = "</script><script>document.title='gone'</script><!--<img src=x onerror=alert(1)>"
    landmarks = [replace(m, name=evil) if m.id == "Ivy" else m for m in city.landmarks]
    city = replace(city, name=evil, landmarks=tuple(landmarks), _cache={})
    said = sloop.parse("the red bike is near velvet dog", city)
    posterior = sloop.infer(replace(said, text=f"{said.text} {evil}"), city)
    path = tmp_path / "evil.html"
    write_page(path, posterior)
    page = open_file(path)
    assert page.title() != "gone"
    assert evil in page.inner_text(".said")
    assert page.locator("img").count() == 0


def test_the_same_search_makes_the_same_bytes(tmp_path):
    posterior = sloop.infer(TEXT, "cleveland")
    for name in ("a.html", "b.html"):
        episode = sloop.search(
            posterior, posterior.city, PLACE, rng=np.random.default_rng(0), keep_beliefs=True
        )
        write_page(tmp_path / name, posterior, episode)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_mistakes_are_said_before_the_work(tmp_path):
    posterior = sloop.infer(TEXT, "cleveland")
    episode = sloop.search(posterior, posterior.city, PLACE, rng=np.random.default_rng(0))
    with pytest.raises(InputError, match="search with keep_beliefs=True"):
        write_page(tmp_path / "a.html", posterior, episode)
    with pytest.raises(OutputError, match=r"expected one of \.html"):
        write_page(tmp_path / "a.htm", posterior)


def test_the_page_makes_the_same_file_as_the_command(open_page, tmp_path):
    page = open_page()
    page.locator("#maps[aria-busy=false]").wait_for(state="attached")
    page.locator("summary", has_text="Keep and share").click()
    with page.expect_download() as kept:
        page.click("#page")
    found = kept.value.path().read_text(encoding="utf-8")
    posterior = sloop.infer(page.input_value("#text"), "cleveland")
    write_page(tmp_path / "a.html", posterior)
    expected = (tmp_path / "a.html").read_text(encoding="utf-8")
    cut = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)
    assert cut.sub("", found) == cut.sub("", expected)
    assert without_key(cut.search(found)[1]) == without_key(cut.search(expected)[1])


def without_key(text):
    data = json.loads(text)
    return {**data, "scene": {**data["scene"], "key": None}}


def test_the_widget_holds_what_the_page_shows():
    posterior = sloop.infer(TEXT, "cleveland")
    shown = sloop.widget(posterior)
    assert shown.payload["belief"]["targets"][0]["id"] == "GreenToyota"
    assert (shown.picked, shown.area, shown.answer) == (None, None, None)
    episode = sloop.search(
        posterior, posterior.city, PLACE, rng=np.random.default_rng(0), keep_beliefs=True
    )
    assert len(sloop.widget(episode).payload["search"]["steps"]) == episode.steps
    with pytest.raises(InputError, match="expected a posterior or an episode"):
        sloop.widget("cleveland")


HOST = """
<!doctype html><html lang="en"><title>host</title><div id="cell"></div>
<script type="application/json" id="payload">{payload}</script>
<script type="module">
{module}
const values = {{ payload: JSON.parse(document.getElementById("payload").textContent) }};
const model = {{ get: (k) => values[k], set: (k, v) => {{ values[k] = v; }}, on() {{}},
  save_changes() {{ document.title = JSON.stringify([values.picked, values.area]); }} }};
render({{ model, el: document.getElementById("cell") }});
</script></html>"""


def test_the_widget_sends_back_what_is_drawn(open_file, tmp_path):
    """A stand-in for a notebook, which hands the module a model and an element."""
    from sloop_ppl.web._stylesheet import static_text

    shown = sloop.widget(sloop.infer(TEXT, "cleveland"))
    payload = json.dumps(shown.payload).replace("<", "\\u003c")
    path = tmp_path / "host.html"
    path.write_text(HOST.format(payload=payload, module=static_text("view.js")))
    page = open_file(path)
    page.get_by_role("button", name="Not here").click()
    box = page.locator("svg.map").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    picked, _ = json.loads(page.title())
    west, south, east, north = shown.payload["scene"]["cells_extent_m"]
    assert picked["at"] == pytest.approx([(west + east) / 2, (south + north) / 2], abs=1)
    assert (picked["target"], picked["is_there"]) == ("GreenToyota", False)
    page.get_by_role("button", name="Area").click()
    page.mouse.move(box["x"] + 10, box["y"] + 10)
    page.mouse.down()
    page.mouse.move(box["x"] + 60, box["y"] + 60)
    page.mouse.move(box["x"] + 90, box["y"] + 110)
    page.mouse.up()
    _, area = json.loads(page.title())
    assert area[0] < area[2]
    assert area[1] < area[3]
    page.get_by_role("button", name="Polygon").click()
    for dx, dy in ((20, 20), (120, 30), (70, 120), (20, 20)):
        page.mouse.click(box["x"] + dx, box["y"] + dy)
    _, corners = json.loads(page.title())
    assert len(corners) == 3
    assert all(len(corner) == 2 for corner in corners)
