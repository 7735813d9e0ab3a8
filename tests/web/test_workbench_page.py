"""The workbench in Chromium: what is drawn is what the library says."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from support.workbench import (
    address,
    click_at,
    colours_of,
    drawn_belief,
    on_screen,
    settle,
    state_of,
    type_text,
)

import sloop_ppl as sloop

pytestmark = pytest.mark.xdist_group("chromium")

TEXT = "The green Toyota is in front of Hoyt Block, on West 6th Street."
CLEVELAND = sloop.load_map("cleveland")
GRID = CLEVELAND.grid


def search(page):
    """Search to the end and return the number of steps, the player paused."""
    page.click("#search")
    page.locator("#player[data-ended]").wait_for()
    page.get_by_label("Step of the search").fill("0")  # which pauses, played to the end or not
    return int(page.locator("#player").get_attribute("data-ended"))


def test_the_first_screen_explains_itself_and_leads_to_a_found_car(open_page, picture):
    page = open_page()
    settle(page)
    assert page.input_value("#text") == TEXT
    assert [h.inner_text() for h in page.locator("h2").all()] == [
        "1\nSay where it is", "2\nSee where it may be", "3\nSend the drone",
    ]  # fmt: skip
    assert "within 15 m of Hoyt Block" in page.inner_text("#where")
    picture(page, "workbench-light")
    page.click("text=Search for it")
    page.locator("#search-state", has_text=re.compile(r"Found after \d+ steps")).wait_for()
    assert page.inner_text(".step-line").endswith("Found.")
    picture(page, "workbench-search-light")


def test_what_is_drawn_is_the_belief(open_page):
    page = open_page()
    settle(page)
    belief = sloop.infer(TEXT, CLEVELAND).belief("GreenToyota")
    expected = colours_of(belief)
    drawn = drawn_belief(page).astype(float)
    assert drawn.shape == (*GRID.shape, 4)
    # Colours of transparent pixels are rounded by the canvas, which keeps them multiplied.
    assert np.abs(drawn[..., 3] - expected[..., 3]).max() <= 1
    seen = expected[..., 3] > 100
    assert np.abs(drawn - expected)[seen].max() <= 3


def test_the_number_under_the_pointer_is_that_of_the_cell(open_page):
    page = open_page()
    settle(page)
    belief = sloop.infer(TEXT, CLEVELAND).belief("GreenToyota")
    for row, col in ((6, 26), (20, 10), (0, 0), (40, 39)):
        x, y = GRID.centre_of(row, col)
        page.mouse.move(*on_screen(page, x, y))
        shown = page.inner_text("#readout")
        assert percent(shown) == pytest.approx(100 * belief[row, col], rel=0.06, abs=0.01)


def percent(text):
    return float(text.replace("%", "").replace("<", "").strip())


def test_contours_enclose_the_cells_of_the_smallest_set(open_page):
    page = open_page()
    settle(page)
    posterior = sloop.infer(TEXT, CLEVELAND)
    for name, mass in (("hpd90", 0.9), ("hpd50", 0.5)):
        path = page.locator(f"#map-a .contours .{name} path:not(.halo)").get_attribute("d")
        assert edges_of(path) == borders(posterior.hpd("GreenToyota", mass))


def edges_of(path):
    """Return the middles of the edges of a path of unit segments."""
    found = set()
    for x, y, way, length in re.findall(r"M(\S+) (\S+?)([hv])(-?[\d.]+)", path):
        half = float(length) / 2
        dx, dy = (half, 0) if way == "h" else (0, half)
        found.add((float(x) + dx, -(float(y) + dy)))
    return found


def borders(mask):
    """Return the middles of the edges between cells in and out of a set."""
    side, found = GRID.cell_m, set()
    wide = np.pad(mask, 1)
    for row, col in np.argwhere(wide):
        x, y = GRID.x_m[0] + (col - 1) * side, GRID.y_m[0] + (row - 1) * side
        for dr, dc in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            if not wide[row + dr, col + dc]:
                found.add((float(x + dc * side / 2), float(y + dr * side / 2)))
    return found


def test_arrows_point_where_the_grounds_face(open_page):
    page = open_page()
    page.locator("#map-a .frame").first.wait_for(state="attached")
    expected = [f for f in sloop.infer(TEXT, CLEVELAND).frames("GreenToyota") if f.p >= 0.02]
    angles = page.locator("#map-a .frame").evaluate_all(
        """nodes => nodes.map(node => {
            const m = node.getScreenCTM();
            return [Math.atan2(-m.b, m.a), m.e, m.f];
        })"""
    )
    assert len(angles) == len(expected)
    for (angle, e, f), frame in zip(angles, expected, strict=True):
        assert math.remainder(angle - frame.mean_rad, 2 * math.pi) == pytest.approx(0, abs=1e-3)
        assert (e, f) == pytest.approx(on_screen(page, *CLEVELAND.centroid(frame.ground)), abs=1)


def test_typing_is_read_while_one_types(open_page):
    page = open_page()
    settle(page)
    page.fill("#text", "")
    page.locator("#text").press_sequentially("the red bike is near a bar or at ivy, not near RTA")
    page.locator("#phrases li").nth(2).wait_for()
    marks = page.locator("#marks mark").evaluate_all("m => m.map(n => [n.className, n.innerText])")
    assert ["figure", "red bike"] in [[c.split()[0], t] for c, t in marks]
    assert any("denied" in c and t == "RTA" for c, t in marks)
    # What is drawn behind lies under the letters.
    area, back = page.locator("#text").bounding_box(), page.locator("#marks").bounding_box()
    assert (area["x"], area["y"]) == pytest.approx((back["x"], back["y"]), abs=1)
    bar = page.locator("#phrases li", has_text="near").first
    bar.hover()
    assert bar.locator(".alternatives").is_visible()
    type_text(page, "the red bike is near ivy and beside the Zzyzx Palace")
    assert "Zzyzx" in page.inner_text("#unread")
    type_text(page, "good morning")
    assert page.locator("#problem").is_visible()
    assert page.locator("#search").is_disabled()


def test_a_phrase_is_switched_off_and_on(open_page):
    page = open_page()
    settle(page)
    before = page.inner_text("#where")
    page.get_by_label("on West 6th Street").uncheck()
    settle(page)
    assert page.inner_text("#where") != before
    assert state_of(page)["off"] == [1]
    belief = sloop.infer("The green Toyota is in front of Hoyt Block", CLEVELAND)
    x, y = belief.mode("GreenToyota")
    page.mouse.move(*on_screen(page, x, y))
    expected = 100 * belief.belief("GreenToyota").max()
    assert percent(page.inner_text("#readout")) == pytest.approx(expected, rel=0.06)
    page.get_by_label("on West 6th Street").check()
    settle(page)
    assert page.inner_text("#where") == before


def test_evidence_by_click_and_undo(open_page):
    page = open_page()
    settle(page)
    before = drawn_belief(page)
    page.get_by_label("Not here").check()
    x, y = sloop.infer(TEXT, CLEVELAND).mode("GreenToyota")
    with page.expect_response("**/api/belief"):
        click_at(page, x, y)
    settle(page)
    (evidence,) = state_of(page)["evidence"]
    assert evidence["at"] == pytest.approx([x, y], abs=0.5)
    assert not evidence["is_there"]
    assert page.locator("#map-a .evidence .absent").count() == 1
    after = drawn_belief(page)
    cell = GRID.cell_at(x, y)
    assert after[cell][3] < before[cell][3]
    page.click("#undo")
    settle(page)
    assert (drawn_belief(page) == before).all()
    assert "evidence" not in state_of(page)


def test_keys_alone_suffice(open_page):
    page = open_page()
    settle(page)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.keyboard.press("Enter")
    page.locator("#map-a svg.map").focus()
    page.keyboard.press("ArrowUp")
    row, col = GRID.n_rows // 2 + 1, GRID.n_cols // 2
    belief = sloop.infer(TEXT, CLEVELAND).belief("GreenToyota")
    shown = re.search(r"([\d.]+) % in this cell", wait_live(page, "in this cell"))
    assert float(shown[1]) == pytest.approx(100 * belief[row, col], rel=0.06, abs=0.01)
    page.keyboard.press("Shift+ArrowDown")
    with page.expect_response("**/api/belief"):
        page.keyboard.press("n")
    settle(page)
    (evidence,) = state_of(page)["evidence"]
    assert evidence["at"] == pytest.approx(GRID.centre_of(row - 5, col))
    page.keyboard.press("a")
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowUp")
    with page.expect_response("**/api/belief"):
        page.keyboard.press("a")
    west, south, east, north = state_of(page)["area"]
    assert (east - west, north - south) == pytest.approx((15, 5))
    settle(page)
    page.keyboard.press("Control+z")
    settle(page)
    assert "area" not in state_of(page)
    page.locator("#search").focus()
    page.keyboard.press("Enter")
    page.locator(".step-line").wait_for()
    page.locator("#player[data-ended]").wait_for()
    page.locator(".play").press("Enter")
    page.get_by_role("button", name="First step").press("Enter")
    page.get_by_role("button", name="One step on").press("Enter")
    assert re.match(r"Step \d+: the drone", page.inner_text(".step-line"))


def wait_live(page, text):
    page.locator("#live", has_text=text).wait_for()
    return page.inner_text("#live")


def test_an_area_is_drawn_and_places_are_set(open_page):
    page = open_page()
    settle(page)
    page.get_by_label("Area", exact=True).check()
    (x0, y0), (x1, y1) = on_screen(page, -20, 0), on_screen(page, 60, -95)
    page.mouse.move(x0, y0)
    page.mouse.down()
    page.mouse.move((x0 + x1) / 2, (y0 + y1) / 2)
    page.mouse.move(x1, y1)
    with page.expect_response("**/api/belief"):
        page.mouse.up()
    settle(page)
    assert state_of(page)["area"] == pytest.approx([-20, -95, 60, 0], abs=1)
    drawn = drawn_belief(page)
    assert drawn[:, GRID.x_m < -21, 3].max() == 0
    for tool, key in (("True place", "places"), ("Start", "start")):
        page.get_by_label(tool).check()
        with page.expect_response("**/api/belief"):
            click_at(page, 30, -40)
        found = state_of(page)[key]
        assert (found["GreenToyota"] if key == "places" else found) == pytest.approx(
            [30, -40], abs=0.5
        )
    assert page.locator("#map-a .marks .place").count() == 1


def test_a_link_reloads_the_same(open_page, browser, server):
    state = {"map": "austin", "text": "The red bike is near Norwood Tower, or north of Facebook",
             "model": "sloop-m4", "off": [1], "layer": "change", "area": [-90, -90, 90, 90],
             "evidence": [{"target": "RedBike", "at": [0, 50], "radius_m": 15,
                           "is_there": True}]}  # fmt: skip
    page = open_page(address(**state))
    settle(page)
    assert page.input_value("#text") == state["text"]
    assert page.input_value("#model") == "sloop-m4"
    assert page.get_by_label("Change", exact=True).is_checked()
    first = drawn_belief(page)
    link = page.url
    other = open_page("/" + link.partition("/#")[2].join(["#", ""]))
    settle(other)
    assert (drawn_belief(other) == first).all()
    assert state_of(other) == state_of(page)


def test_a_damaged_link_shows_the_example(open_page):
    for fragment in ("#%7Bnot", "#[]", "#7", "#%7B%22text%22%3A%207%7D", "#%"):
        page = open_page("/" + fragment)
        assert page.input_value("#text") == TEXT


def test_two_models_side_by_side_and_their_difference(open_page, picture):
    page = open_page(address(map="cleveland", text=TEXT, compare="keyword", layer="belief"))
    page.locator("#map-b svg.map").wait_for()
    settle(page)
    assert page.inner_text("#caption-a") == "bayes"
    assert page.inner_text("#caption-b") == "keyword"
    keyword = sloop.infer(TEXT, CLEVELAND, model="keyword").belief("GreenToyota")
    assert ((drawn_belief(page, "#map-b")[..., 3] > 200) == (keyword > 0.5 * keyword.max())).all()
    page.get_by_label("Change", exact=True).check()
    assert page.inner_text("#caption-a") == "bayes minus keyword"
    change = sloop.infer(TEXT, CLEVELAND).belief("GreenToyota") - keyword
    drawn = drawn_belief(page).astype(int)
    strong = np.abs(change) > 0.3 * np.abs(change).max()
    blue = drawn[..., 2] > drawn[..., 0]
    assert (blue == (change > 0))[strong].all()
    picture(page, "compare-light")


def test_a_search_is_played_back_and_forth(open_page):
    page = open_page()
    settle(page)
    steps = search(page)
    page.get_by_role("button", name="First step").click()
    assert page.inner_text(".step-line") == "Before the first step."
    first = drawn_belief(page)
    page.get_by_role("button", name="One step on").click()
    assert page.inner_text(".step-line").startswith("Step 1: the drone")
    assert page.locator(".step-values .best").count() == 1
    assert page.locator("#map-a .path .plan").get_attribute("d").count("L") > 2
    page.get_by_role("button", name="One step back").click()
    assert (drawn_belief(page) == first).all()
    slider = page.get_by_label("Step of the search")
    assert int(slider.get_attribute("max")) == steps
    slider.fill(str(steps))
    assert page.inner_text(".step-line").endswith("Found.")
    episode = sloop.search(
        sloop.infer(TEXT, CLEVELAND), CLEVELAND, {"GreenToyota": (27.5, -67.5)},
        rng=np.random.default_rng(0),
    )  # fmt: skip
    assert episode.steps == steps
    flown = page.locator("#map-a .path .flown:not(.halo)").get_attribute("d")
    points = [tuple(map(float, p)) for p in re.findall(r"[ML](\S+) (\S+?)(?=[ML]|$)", flown)]
    assert points == [(pose.x_m, -pose.y_m) for pose in episode.poses]
    with page.expect_download() as kept:
        page.locator("summary", has_text="Keep and share").click()
        page.click("#episode")
    record = json.loads(kept.value.path().read_text())
    assert record["actions"] == list(episode.actions)


def test_something_is_said_during_the_search(open_page):
    page = open_page(address(map="cleveland", text="the red bike is near ivy",
                             places={"RedBike": [-42.5, 72.5]}, start=[80, -80]))  # fmt: skip
    settle(page)
    search(page)
    page.get_by_label("Step of the search").fill("3")
    before = drawn_belief(page)
    page.fill("#say", "it is east of ivy")
    page.click("text=Say it")
    page.locator("#player:not([data-ended])").wait_for(state="attached")
    page.locator("#player[data-ended]").wait_for()
    assert state_of(page)["sayings"] == {"3": "it is east of ivy"}
    page.get_by_label("Step of the search").fill("3")
    assert (drawn_belief(page) != before).any()


def test_a_search_is_stopped(open_page):
    page = open_page(address(map="cleveland", text="the red bike is near ivy", planner="pouct",
                             places={"RedBike": [97, -97]}, steps=1000))  # fmt: skip
    settle(page)
    page.click("#search")
    page.locator(".step-line").wait_for()
    page.click("#stop")
    import multiprocessing

    for _ in range(600):
        if not multiprocessing.active_children():
            break
        page.wait_for_timeout(100)
    assert multiprocessing.active_children() == []
    assert page.locator("#problem").is_hidden()


def test_a_map_file_is_opened(open_page, tmp_path):
    from sloop_ppl.maps import write_map

    city = CLEVELAND.window((0, 0), 120)
    path = tmp_path / "my block.geojson"
    write_map(city, path)
    page = open_page(expected=("422",))
    settle(page)
    page.set_input_files("#file", path)
    page.locator("#map-note", has_text="my block is open").wait_for()
    assert page.locator("#map option:checked").inner_text() == "my block"
    type_text(page, "the red bike is near the hat factory")
    drawn = drawn_belief(page)
    assert drawn.shape[:2] == city.grid.shape
    (tmp_path / "bad.geojson").write_text("{}")
    page.set_input_files("#file", tmp_path / "bad.geojson")
    page.locator("#problem", has_text=re.compile(".")).wait_for()
    assert "Traceback" not in page.inner_text("#problem")


def test_a_map_that_is_not_here_is_said(open_page):
    path = address(map="0123456789abcdef", text="the red bike is near ivy")
    page = open_page(path, expected=("404",))
    page.locator("#problem", has_text="This map is not here; drop its file").wait_for()


class FakeQuestion:
    """Is it north of the middle? As `sloop_ppl.bridge.ask` would ask, whatever it asks."""

    text, bits = "Is it north of Ivy?", 0.8
    answers = (("yes", 0.6), ("no", 0.4))

    def answer(self, text):
        word = "north of" if text == "yes" else "south of"
        return sloop.parse(f"the red bike is {word} ivy", CLEVELAND)


def test_an_answer_to_a_question_moves_the_belief(open_page, monkeypatch):
    from sloop_ppl import bridge

    monkeypatch.setattr(bridge, "ask", lambda posterior, city, n: (FakeQuestion(),))
    page = open_page(address(map="cleveland", text="the red bike is near ivy"))
    settle(page)
    page.locator("#questions-box summary").click()
    with page.expect_response("**/api/belief"):
        page.get_by_role("button", name="no (40 %)").click()
    page.locator("#questions", has_text="Is it north of Ivy? no").wait_for()
    settle(page)
    assert state_of(page)["answers"] == [["Is it north of Ivy?", "no"]]
    said = sloop.infer("the red bike is near ivy", CLEVELAND)
    belief = said.update(FakeQuestion().answer("no")).belief("RedBike")
    assert np.abs(drawn_belief(page)[..., 3] - colours_of(belief)[..., 3]).max() <= 1
    page.get_by_role("button", name="Take back").click()
    page.locator("#questions", has_text="Take back").wait_for(state="detached")
    settle(page)
    assert "answers" not in state_of(page)
