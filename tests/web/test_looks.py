"""Every page, light and dark, from a telephone to 4K: nothing inaccessible, nothing cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("chromium")

AXE = Path(__file__).parents[2] / "out/axe/node_modules/axe-core/axe.min.js"
PAGES = {
    "workbench": "/",
    "search": "/",
    "settings": "/",
    "frames": "/frames",
    "collect-example": "/collect",
    "collect": "/collect",
    "progress": "/progress",
}


def show(page, name):
    """Bring a page into the state that is looked at."""
    if name in ("workbench", "search", "settings"):
        page.locator("#maps[aria-busy=false]").wait_for(state="attached")
    if name == "search":
        page.click("#search")
        page.locator("#player[data-ended]").wait_for()
        page.locator(".play").click()
        page.get_by_label("Step of the search").fill("9")
    if name == "settings":
        for box in ("why-box", "meant-box", "model-box", "evidence-box", "keep-box"):
            page.locator(f"#{box} summary").click()
        page.locator("#why li").first.wait_for()
    if name == "frames":
        page.keyboard.press("ArrowUp")
    if name == "collect":
        page.check("#consent")
        page.click("#begin")
        page.locator(".object").first.wait_for()
    page.wait_for_timeout(400)  # what is announced comes a little later


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_no_serious_fault(open_page, picture, name, scheme):
    if not AXE.exists():
        pytest.skip("axe-core is not installed; make test-web fetches it from npm")
    page = open_page(PAGES[name], color_scheme=scheme, bypass_csp=True)
    show(page, name)
    picture(page, f"{name}-{scheme}")
    page.add_script_tag(path=AXE)
    found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
    serious = [
        (fault["id"], [node["html"][:120] for node in fault["nodes"]])
        for fault in found["violations"]
        if fault["impact"] in ("serious", "critical")
    ]
    assert serious == []
    assert len(found["passes"]) > 10


@pytest.mark.parametrize("width", [360, 768, 1280, 3840])
@pytest.mark.parametrize("name", PAGES)
def test_nothing_is_cut_off(open_page, name, width):
    page = open_page(PAGES[name], viewport={"width": width, "height": max(640, width // 2)})
    show(page, name)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    off = page.evaluate(
        """() => [...document.querySelectorAll("button, select, textarea, summary, input, svg.map")]
            .filter(n => n.checkVisibility() && n.type !== "file" && n.type !== "radio")
            .map(n => [n, n.getBoundingClientRect()])
            .filter(([n, r]) => r.left < -0.5 || r.right > innerWidth + 0.5 || r.width < 8)
            .map(([n]) => n.outerHTML.slice(0, 80))"""
    )
    assert off == []


@pytest.mark.parametrize("name", ["workbench", "frames", "collect"])
def test_twice_as_large_is_readable(open_page, name):
    """Zoom of 200 % is half the width at twice the pixels."""
    page = open_page(PAGES[name], viewport={"width": 640, "height": 430}, device_scale_factor=2)
    show(page, name)
    assert page.evaluate("document.documentElement.scrollWidth") <= 640


def test_the_focus_is_seen(open_page):
    page = open_page()
    for _ in range(12):
        page.keyboard.press("Tab")
        shown = page.evaluate(
            """() => {
                const n = document.activeElement, next = n.nextElementSibling;
                const styled = n.type === "radio" ? next : n.type === "file" ? n.parentElement : n;
                const style = getComputedStyle(styled);
                const width = parseFloat(style.outlineWidth);
                return [n.outerHTML.slice(0, 60), style.outlineStyle, width];
            }"""
        )
        assert shown[1] != "none", shown
        assert shown[2] >= 2, shown


def test_nothing_jumps_while_one_reads(open_page):
    """The place of the map and the buttons stays while the sentence and the belief change."""
    page = open_page()
    page.locator("#maps[aria-busy=false]").wait_for(state="attached")

    def places():
        return page.evaluate(
            """() => ["#map-a svg.map", "#search", "#text"].map(q => {
                const r = document.querySelector(q).getBoundingClientRect();
                return [r.x, r.y, r.width, r.height]; })"""
        )

    before = places()
    for text in (
        "The green Toyota is near Ivy, at Velvet Dog.",
        "The red bike is at RTA, near Ivy.",
    ):
        page.fill("#text", text)
        page.locator("#maps[aria-busy=false]").wait_for(state="attached")
        assert places() == before
    page.get_by_label("Change", exact=True).check()
    assert places() == before


def test_the_theme_is_kept(open_page):
    page = open_page(color_scheme="light")
    ground = "getComputedStyle(document.querySelector('svg.map .ground')).fill"
    light = page.evaluate(ground)
    page.click("#theme")
    dark = page.evaluate(ground)
    assert dark != light
    page.goto(page.url.partition("#")[0] + "frames")
    page.locator("body[data-ready]").wait_for()
    assert page.evaluate(ground) == dark


def test_names_of_any_script_are_shown(open_page, tmp_path):
    from dataclasses import replace

    import sloop_ppl as sloop
    from sloop_ppl.maps import write_map

    names = ("北京烤鸭店", "مقهى النخيل", "Кофейня", "ร้านกาแฟ")
    city = sloop.load_map("cleveland")
    ids = [m.id for m in city.landmarks if m.name and m.kind == "building"][: len(names)]
    renamed = dict(zip(ids, names, strict=True))
    landmarks = [replace(m, name=renamed.get(m.id, m.name)) for m in city.landmarks]
    path = tmp_path / "scripts.geojson"
    write_map(replace(city, landmarks=tuple(landmarks), _cache={}), path)
    page = open_page()
    page.set_input_files("#file", path)
    page.locator("#map-note", has_text="scripts is open").wait_for()
    page.locator("#map-a .name", has_text=names[0]).wait_for(state="attached")
    shown = page.locator("#map-a .name").all_text_contents()
    assert set(names) <= set(shown)


def test_less_motion_where_it_is_asked_for(open_page):
    page = open_page(reduced_motion="reduce")
    moving = page.evaluate(
        """() => [...document.querySelectorAll("*")].filter(n =>
            !["0s", ""].includes(getComputedStyle(n).transitionDuration)).length"""
    )
    assert moving == 0
