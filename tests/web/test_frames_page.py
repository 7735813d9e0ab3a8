"""Annotating frames in Chromium: by mouse, and by keys alone."""

from __future__ import annotations

import json
import math

import pytest
from support.web_server import GUEST, TOKEN, running

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.eval import read_descriptions
from sloop_ppl.eval._frame_annotations import read_judgements
from sloop_ppl.web._frame_queue import items_of_file, items_of_map
from sloop_ppl.web.application import WebSettings

pytestmark = pytest.mark.xdist_group("chromium")

CLEVELAND = sloop.load_map("cleveland")


@pytest.fixture
def annotating(tmp_path):
    """A server of its own, whose file is empty."""
    settings = WebSettings(
        maps=("cleveland",), token=TOKEN, guest_token=GUEST, folder=tmp_path / "kept"
    )
    with running(settings) as served:
        yield served


def records(server):
    path = server.settings.folder / "frames.jsonl"
    return [json.loads(line) for line in path.read_text().splitlines()]


def on_screen(page, x_m, y_m):
    return page.evaluate(
        """([x, y]) => {
            const root = document.querySelector("svg.map");
            const at = new DOMPoint(x, -y).matrixTransform(root.getScreenCTM());
            return [at.x, at.y];
        }""",
        [x_m, y_m],
    )


def test_an_arrow_is_clicked_and_the_right_one_appears(open_page, annotating, picture):
    page = open_page("/frames", base=annotating.url)
    page.fill("#annotator", "Ada")
    page.locator("#annotator").blur()
    item = items_of_map(CLEVELAND, "cleveland")[0]
    assert item.text in page.inner_text("#phrase")
    x, y = CLEVELAND.centroid(item.ground)
    assert page.locator(".vector-front").count() == 0
    page.mouse.click(*on_screen(page, x + 30, y + 30))
    angles = page.locator("svg.map .frames g").evaluate_all(
        "nodes => nodes.map(n => { const m = n.getCTM(); return Math.atan2(-m.b, m.a); })"
    )
    assert angles == pytest.approx([-math.pi / 4, math.pi / 4], abs=1e-3)  # right, front
    outline = page.locator("svg.map .mentioned path").get_attribute("d")
    assert outline == page.locator(f"svg.map .land [data-id={item.ground}]").get_attribute("d")
    picture(page, "frames-light")
    page.click("#save")
    page.locator("#count", has_text="1 done").wait_for()
    (record,) = records(annotating)
    assert record["frames"] == [
        {"ground": item.ground, "relation": "front", "annotator": "Ada",
         "front_deg": pytest.approx(45, abs=0.5)}
    ]  # fmt: skip
    assert record["origin_m"] == pytest.approx([x, y], abs=0.01)


def test_an_arrow_is_dragged_from_where_it_begins(open_page, annotating):
    page = open_page("/frames", base=annotating.url)
    page.fill("#annotator", "Ada")
    page.mouse.move(*on_screen(page, -40, 0))
    page.mouse.down()
    page.mouse.move(*on_screen(page, -40, -20))
    page.mouse.move(*on_screen(page, -40, -50))
    page.mouse.up()
    page.click("#save")
    page.locator("#count", has_text="1 done").wait_for()
    (record,) = records(annotating)
    assert record["frames"][0]["front_deg"] == pytest.approx(-90, abs=0.5)
    assert record["origin_m"] == pytest.approx([-40, 0], abs=0.5)


def test_keys_alone_suffice(open_page, annotating):
    page = open_page("/frames", base=annotating.url)
    page.locator("#annotator").focus()
    page.keyboard.type("Bob")
    page.keyboard.press("Tab")
    page.locator("#count", has_text="0 done").wait_for()
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("ArrowUp")  # an arrow to the north appears
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("o")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")
    page.locator("#count", has_text="1 done").wait_for()
    page.keyboard.press("u")
    page.locator("#count", has_text="2 done").wait_for()
    page.keyboard.press("s")
    page.locator("#count", has_text="Phrase 4").wait_for()
    page.keyboard.press("b")
    page.keyboard.press("b")
    page.locator("#count", has_text="this one is unclear").wait_for()
    first, second = records(annotating)
    items = items_of_map(CLEVELAND, "cleveland")
    assert first["frames"][0]["front_deg"] == pytest.approx(96)
    x, y = CLEVELAND.centroid(items[0].ground)
    assert first["origin_m"] == pytest.approx([x + 1, y], abs=0.01)
    assert second["frames"] == []
    assert second["unclear"] == {
        "ground": items[1].ground, "relation": "front", "annotator": "Bob",
    }  # fmt: skip


def test_what_was_saved_is_there_again_and_can_be_changed(open_page, annotating):
    for angle in ((0, 20), (20, 0)):
        page = open_page("/frames", base=annotating.url)
        page.fill("#annotator", "Cleo")
        page.locator("#annotator").blur()
        if angle == (20, 0):
            page.locator("#count", has_text="Phrase 2 of").wait_for()
            page.click("#back")
            page.locator("#count", has_text="this one is done").wait_for()
            assert "towards north" in page.inner_text("#angle")
        x, y = CLEVELAND.centroid(items_of_map(CLEVELAND, "cleveland")[0].ground)
        page.mouse.click(*on_screen(page, x + angle[0], y + angle[1]))
        page.click("#save")
        page.locator("#count", has_text="Phrase 2 of").wait_for()
        page.locator("#save:disabled").wait_for()
    first, second = records(annotating)
    assert second["id"] == f"{first['id']}#2"
    (judged,) = read_judgements([annotating.settings.folder / "frames.jsonl"])
    assert judged.front_rad == pytest.approx(0, abs=0.02)
    # The file is a description file, too.
    lines = read_descriptions([annotating.settings.folder / "frames.jsonl"])
    assert [one.frames[0].front_deg for one in lines] == pytest.approx([90, 0], abs=1)


def test_an_arrow_drawn_before_the_name_is_kept(open_page, annotating):
    page = open_page("/frames", base=annotating.url)
    x, y = CLEVELAND.centroid(items_of_map(CLEVELAND, "cleveland")[0].ground)
    page.mouse.click(*on_screen(page, x, y + 20))
    page.locator("#angle", has_text="Enter your name to save").wait_for()
    page.fill("#annotator", "Dee")
    page.locator("#annotator").blur()
    page.click("#save")
    page.locator("#count", has_text="Phrase 2 of").wait_for()
    page.locator("#save:disabled").wait_for()
    (line,) = read_descriptions([annotating.settings.folder / "frames.jsonl"])
    assert line.frames[0].front_deg == pytest.approx(90, abs=1)


def test_annotators_do_not_see_each_other(annotating):
    item = items_of_map(CLEVELAND, "cleveland")[0]
    body = {"item": item.id, "map": "cleveland", "origin": [0, 0], "end": [0, 9], "seconds": 1}
    assert annotating.json("POST", "/api/frames/annotations", {**body, "annotator": "A"})[1] == {
        "id": f"{item.id}@A", "front_deg": 90.0,
    }  # fmt: skip
    assert list(annotating.json("GET", "/api/frames/queue?annotator=A")[1]["done"]) == [item.id]
    assert annotating.json("GET", "/api/frames/queue?annotator=B")[1]["done"] == {}
    status, answer = annotating.json(
        "POST", "/api/frames/annotations", {**body, "annotator": "A", "end": [0, 0]}
    )
    assert (status, "no length" in answer["error"]) == (422, True)
    assert annotating.ask("POST", "/api/frames/annotations", {**body, "annotator": " "})[0] == 400
    other = {**body, "annotator": "A", "item": "nothing"}
    assert annotating.ask("POST", "/api/frames/annotations", other)[0] == 404


def test_a_queue_of_a_file_has_what_depends_on_a_frame(tmp_path):
    lines = [
        {"id": "a", "map": "cleveland", "text": "the red bike is behind ivy and near rumor",
         "relations": [{"figure": "RedBike", "relation": "behind", "ground": "Ivy"},
                       {"figure": "RedBike", "relation": "near", "ground": "Rumor"}]},
        {"id": "b", "map": "cleveland", "text": "the red bike is left of velvet dog"},
    ]  # fmt: skip
    path = tmp_path / "said.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert [(i.id, i.ground, i.relation) for i in items_of_file(path)] == [
        ("a/Ivy/behind", "Ivy", "behind"), ("b/VelvetDog/left", "VelvetDog", "left"),
    ]  # fmt: skip
    path.write_text(json.dumps({**lines[0], "relations": lines[0]["relations"][1:]}) + "\n")
    with pytest.raises(InputError, match="holds no front, behind, left or right"):
        items_of_file(path)


def test_points_are_highlighted(open_page, annotating):
    """Velvet Dog is a point; its own mark and the house around it are shown."""
    assert CLEVELAND.landmark("VelvetDog").geometry.geom_type == "Point"
    items = items_of_map(CLEVELAND, "cleveland")
    page = open_page("/frames", base=annotating.url)
    for _ in range([i.ground for i in items].index("VelvetDog")):
        page.click("#skip")
    page.locator("#phrase", has_text="Velvet Dog").wait_for()
    assert page.locator("svg.map .mentioned circle").count() == 1
    assert (
        page.locator("svg.map .mentioned circle").evaluate("n => n.getBoundingClientRect().width")
        > 8
    )
