"""The search area as a polygon: drawn by mouse and by keys, kept in the link."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import Polygon
from support.workbench import (
    address,
    click_at,
    colours_of,
    drawn_belief,
    on_screen,
    settle,
    state_of,
)

import sloop_ppl as sloop

pytestmark = pytest.mark.xdist_group("chromium")

TEXT = "the red bike is near ivy"
CLEVELAND = sloop.load_map("cleveland")
CORNERS = [(-90, 90), (-10, 80), (-20, 20), (-60, 60)]


def is_drawn(page, corners):
    belief = sloop.infer(TEXT, CLEVELAND, area=Polygon(corners)).belief("RedBike")
    return np.abs(drawn_belief(page)[..., 3] - colours_of(belief)[..., 3]).max() <= 1


def test_a_polygon_is_drawn_by_mouse(open_page):
    page = open_page(address(map="cleveland", text=TEXT))
    settle(page)
    page.get_by_label("Polygon").check()
    for count, corner in enumerate(CORNERS, start=1):
        click_at(page, *corner)
        assert page.locator("#map-a .draft circle").count() == count
    with page.expect_response("**/api/belief"):
        click_at(page, *CORNERS[0])
    settle(page)
    assert page.locator("#map-a .draft circle").count() == 0
    drawn = state_of(page)["polygon"]
    assert np.abs(np.subtract(drawn, CORNERS)).max() < 0.6  # a pixel
    assert is_drawn(page, drawn)
    other = open_page("/#" + page.url.partition("#")[2])
    settle(other)
    assert (drawn_belief(other) == drawn_belief(page)).all()
    # A rectangle takes its place, and back.
    page.get_by_label("Area", exact=True).check()
    (x0, y0), (x1, y1) = on_screen(page, -80, 0), on_screen(page, 0, 90)
    page.mouse.move(x0, y0)
    page.mouse.down()
    page.mouse.move((x0 + x1) / 2, (y0 + y1) / 2)
    page.mouse.move(x1, y1)
    with page.expect_response("**/api/belief"):
        page.mouse.up()
    settle(page)
    assert "polygon" not in state_of(page)
    assert len(state_of(page)["area"]) == 4
    page.click("#undo")
    settle(page)
    assert state_of(page)["polygon"] == drawn
    page.locator("#evidence-box summary").click()
    with page.expect_response("**/api/belief"):
        page.get_by_role("button", name="Remove: Search area").click()
    settle(page)
    assert "polygon" not in state_of(page)


def test_a_double_click_ends_it(open_page):
    page = open_page(address(map="cleveland", text=TEXT))
    settle(page)
    page.get_by_label("Polygon").check()
    for corner in CORNERS[:2]:
        click_at(page, *corner)
    with page.expect_response("**/api/belief"):
        page.mouse.dblclick(*on_screen(page, *CORNERS[2]))
    settle(page)
    assert len(state_of(page)["polygon"]) == 3


def test_a_polygon_is_drawn_by_keys(open_page):
    page = open_page(address(map="cleveland", text=TEXT))
    settle(page)
    page.locator("#map-a svg.map").focus()

    def go(*keys):
        for key in keys:
            page.keyboard.press(key)

    go("Shift+ArrowUp", "o", "Escape")
    assert page.locator("#map-a .draft circle").count() == 0
    go("o", *["Shift+ArrowLeft"] * 3, "o", "Shift+ArrowDown", "o", "Backspace")
    assert page.locator("#map-a .draft circle").count() == 2
    page.locator("#live", has_text="corner").wait_for()
    go(*["Shift+ArrowUp"] * 4, "o")
    with page.expect_response("**/api/belief"):
        go("o")
    settle(page)
    row, col, n = CLEVELAND.grid.n_rows // 2, CLEVELAND.grid.n_cols // 2, 15
    cells = [(row + 5, col), (row + 5, col - n), (row + 20, col - n)]
    expected = [CLEVELAND.grid.centre_of(*cell) for cell in cells]
    assert state_of(page)["polygon"] == [pytest.approx(at, abs=0.1) for at in expected]
    assert is_drawn(page, state_of(page)["polygon"])


def test_a_search_keeps_to_the_polygon(server):
    corners = [[-90, 90], [-10, 80], [-20, 20], [-60, 60]]
    state = {"map": "cleveland", "text": TEXT, "polygon": corners}
    status, answer = server.json("POST", "/api/belief", state)
    assert status == 200
    posterior = sloop.infer(TEXT, CLEVELAND, area=Polygon(corners))
    shown = answer["belief"]["targets"][0]["belief"]["peak"]
    assert shown == pytest.approx(posterior.belief("RedBike").max())


@pytest.mark.parametrize(
    ("polygon", "status", "said"),
    [
        ([[0, 0], [10, 10]], 400, "polygon"),
        ([[0, 0]] * 201, 400, "polygon"),
        ([[0, 0], [10, "a"], [0, 10]], 400, "polygon"),
        ([[0, 0], [50, 50], [50, 0], [0, 50]], 422, "does not cross itself"),
        ([[900, 900], [950, 900], [950, 950]], 422, "outside the map"),
    ],
)
def test_what_is_no_polygon_is_refused(server, polygon, status, said):
    state = {"map": "cleveland", "text": TEXT, "polygon": polygon}
    found, answer = server.json("POST", "/api/belief", state)
    assert found == status
    assert said in answer["error"]
