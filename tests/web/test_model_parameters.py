"""The numbers of the model are changed on the page, within bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.workbench import address, colours_of, drawn_belief, settle, state_of

import sloop_ppl as sloop
from sloop_ppl.models import PRESETS, preset, with_parameters
from sloop_ppl.web._model_parameters import parameters_payload

pytestmark = pytest.mark.xdist_group("chromium")

TEXT = "the red bike is near ivy"
CLEVELAND = sloop.load_map("cleveland")


def row(page, section, name):
    return page.locator(f"#parameters [data-section={section}][data-name={name}]")


def is_drawn(page, model, text=TEXT):
    """Whether the page draws what the library finds with a model, by opacity."""
    belief = sloop.infer(text, CLEVELAND, model=model).belief("RedBike")
    return np.abs(drawn_belief(page)[..., 3] - colours_of(belief)[..., 3]).max() <= 1


def test_a_number_is_changed_undone_and_kept_in_the_link(open_page):
    page = open_page(address(map="cleveland", text=TEXT, model="sloop-m4"))
    settle(page)
    page.locator("#model-box summary").click()
    near = row(page, "likelihood", "near_m")
    assert near.locator("input[type=number]").input_value() == "15"
    assert page.locator("#reset").is_disabled()
    with page.expect_response("**/api/belief"):
        near.locator("input[type=number]").fill("40")
        near.locator("input[type=number]").press("Enter")
    settle(page)
    changed = {"likelihood": {"near_m": 40}}
    assert state_of(page)["parameters"] == changed
    assert is_drawn(page, with_parameters(preset("sloop-m4"), changed))
    other = open_page("/#" + page.url.partition("#")[2])
    settle(other)
    assert (drawn_belief(other) == drawn_belief(page)).all()
    page.click("#undo")
    settle(page)
    assert "parameters" not in state_of(page)
    assert near.locator("input[type=number]").input_value() == "15"
    assert is_drawn(page, preset("sloop-m4"))


def test_a_slider_by_keys_a_switch_and_all_as_they_were(open_page):
    page = open_page(address(map="cleveland", text=f"{TEXT} or near RTA"))
    settle(page)
    page.locator("#model-box summary").click()
    lapse = row(page, "model", "lapse").locator("input[type=range]")
    for _ in range(3):
        with page.expect_response("**/api/belief"):
            lapse.press("ArrowRight")
    settle(page)
    chosen = state_of(page)["parameters"]["model"]["lapse"]
    assert chosen > preset("bayes").lapse
    with page.expect_response("**/api/belief"):
        row(page, "model", "sum_readings").locator("input").uncheck()
    settle(page)
    changed = {"model": {"lapse": chosen, "sum_readings": False}}
    assert state_of(page)["parameters"] == changed
    assert is_drawn(page, with_parameters(preset("bayes"), changed), f"{TEXT} or near RTA")
    with page.expect_response("**/api/belief"):
        page.click("#reset")
    settle(page)
    assert "parameters" not in state_of(page)
    assert is_drawn(page, preset("bayes"), f"{TEXT} or near RTA")


def test_a_drag_of_a_slider_is_one_step_that_can_be_undone(open_page, picture):
    polygon = [[-100, 100], [-30, 100], [-20, 0], [-100, -20]]
    page = open_page(address(map="cleveland", text=TEXT, model="sloop-m2", polygon=polygon))
    settle(page)
    page.locator("#model-box summary").click()
    slider = row(page, "likelihood", "near_m").locator("input[type=range]")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.25 * box["width"], y)
    page.mouse.down()
    values = []
    for share in (0.4, 0.6, 0.8):
        with page.expect_response("**/api/belief"):
            page.mouse.move(box["x"] + share * box["width"], y)
        settle(page)
        values.append(state_of(page)["parameters"]["likelihood"]["near_m"])
    assert values == sorted(values)
    page.mouse.up()
    picture(page, "numbers-light")
    page.click("#undo")
    settle(page)
    assert "parameters" not in state_of(page)
    assert page.locator("#undo").is_disabled()


def test_another_model_has_other_numbers(open_page):
    page = open_page(address(map="cleveland", text=TEXT, parameters={"model": {"lapse": 0.5}},
                             compare="bayes", layer="change"))  # fmt: skip
    page.locator("#map-b svg.map").wait_for()
    settle(page)
    assert page.inner_text("#caption-a") == "bayes, changed minus bayes"
    page.locator("#model-box summary").click()
    row(page, "frames", "kappa").wait_for()
    with page.expect_response("**/api/belief"):
        page.select_option("#model", "sloop-m2")
    row(page, "weights", "near").wait_for()
    assert row(page, "frames", "kappa").count() == 0
    assert "parameters" not in state_of(page)


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_offered_can_be_set_to_either_end(name):
    model = preset(name)
    for one in parameters_payload(model):
        ends = (True, False) if one["high"] is None else (one["low"], one["high"])
        for value in (*ends, one["value"]):
            with_parameters(model, {one["section"]: {one["name"]: value}})
        if one["high"] is not None:
            assert math.isfinite(one["high"])
            assert one["low"] <= one["value"] <= one["high"]
        assert one["meaning"]


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"model": {"lapse": 2}}, "Parameter 'lapse' is 2; expected 0 to 0.99"),
        ({"likelihood": {"near_m": 1e5}}, "Parameter 'near_m' is 100000; expected "),
        ({"model": {"error_m": 9}}, "model.error_m"),
        ({"model": {"lapse": True}}, "Parameter 'lapse' is True; expected a number"),
        ({"model": {"sum_grounds": 0.5}}, "Switch 'sum_grounds' is 0.5; expected true or false"),
        ({"weights": {"__class__": 0.5}}, "weights.__class__"),
    ],
)
def test_a_number_out_of_bounds_is_refused(server, parameters, said):
    state = {"map": "cleveland", "text": TEXT, "parameters": parameters}
    status, answer = server.json("POST", "/api/belief", state)
    assert status == 422
    assert said in answer["error"]


def test_models_are_listed_ones(server):
    for path in ("nothing", "bayes?variant=other", "..%2Fetc", "model.py%3ANAME"):
        status, _, content = server.ask("GET", f"/api/parameters/{path}")
        assert status in (404, 422), content
