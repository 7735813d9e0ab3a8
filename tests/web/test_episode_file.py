"""An episode that a command wrote is opened in the page and played."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from support.workbench import address, drawn_belief, settle, state_of

import sloop_ppl as sloop
from sloop_ppl.cli import main
from sloop_ppl.planning import write_episode

pytestmark = pytest.mark.xdist_group("chromium")

TEXT = "the green toyota is in front of hoyt block"
PLACE = {"GreenToyota": (27.5, -67.5)}
FLOWN = {
    "map": "cleveland",
    "model": "bayes",
    "text": "the red car is near ivy",
    "places": {"RedCar": [-60, 50]},
    "poses": [[0, 70, 180], [-15, 70.5, 180.2], [-15, 70.5, 180.2], [-30, 70, 179], [-30, 70, 179]],
    "actions": ["forward", "forward", "forward", "find"],
    "observations": [{"RedCar": None}, {"RedCar": None}, {"RedCar": [-57.5, 47.5]}, {}],
    "rewards": [-10, -1000, -10, 1000],
    "found": True,
    "found_targets": ["RedCar"],
    "steps": 4,
    "collisions": [{"step": 1, "with": "Building3"}],
    "detections": [[], [], [{"target": "RedCar", "place": [-59.6, 49.7], "share": 1.0}], []],
    "time_s": 25.7,
    "altitude_m": 14.0,
    "wind_m_s": 2.0,
    "detector": "rays",
}


def flown(tmp_path, **changes):
    path = tmp_path / "flight.json"
    path.write_text(json.dumps({**FLOWN, **changes}))
    return path


def drop(page, path):
    """Drop a file onto the page, as a file manager does."""
    transfer = page.evaluate_handle(
        """([name, text]) => {
            const dropped = new DataTransfer();
            dropped.items.add(new File([text], name, { type: "application/json" }));
            return dropped;
        }""",
        [path.name, path.read_text()],
    )
    page.dispatch_event("body", "drop", {"dataTransfer": transfer})


def step_line(page, step):
    page.get_by_label("Step of the search").fill(str(step))
    return page.inner_text(".step-line")


def test_a_flight_is_dropped_and_played(open_page, tmp_path, picture):
    page = open_page(color_scheme="dark")
    settle(page)
    drop(page, flown(tmp_path))
    page.locator("#player[data-ended='4']").wait_for()
    page.locator("#search-state", has_text="Found after 4 steps").wait_for()
    assert page.input_value("#text") == FLOWN["text"]
    note = page.inner_text("#map-note")
    assert "flight is open. Flown 14 m high in wind of 2 m/s, seen by rays; 26 s in the air" in note
    assert "1 collision." in note
    assert step_line(page, 2) == "Step 2: the drone flies on, hits Building3."
    assert step_line(page, 3) == "Step 3: the drone flies on, sees RedCar."
    picture(page, "flight-dark")
    seen = page.locator("#map-a .path .seen")
    assert (seen.get_attribute("cx"), seen.get_attribute("cy")) == ("-59.6", "-49.7")
    assert step_line(page, 4).endswith("Found so far: RedCar. Found.")
    drawn = page.locator("#map-a .path .flown:not(.halo)").get_attribute("d")
    points = [[float(x), -float(y)] for x, y in re.findall(r"[ML](\S+) (\S+?)(?=[ML]|$)", drawn)]
    assert points == [pose[:2] for pose in FLOWN["poses"]]
    turned = page.locator("#map-a .drone").get_attribute("transform")
    assert float(re.search(r"rotate\((\S+)\)", turned)[1]) == pytest.approx(-179)
    assert page.locator("#say-box").is_hidden()
    # The sentence of the flight is read, and undo brings back what was there.
    assert state_of(page)["places"] == {"RedCar": [-60, 50]}
    page.click("#undo")
    settle(page)
    assert page.locator("#player").is_hidden()
    assert "Hoyt Block" in page.input_value("#text")


def test_what_a_search_saved_is_played_as_it_was(open_page, tmp_path, capsys):
    """The command's own files: what it prints, and what it saves with the beliefs."""
    posterior = sloop.infer(TEXT, "cleveland")
    run = sloop.search(
        posterior, posterior.city, PLACE, rng=np.random.default_rng(0), keep_beliefs=True
    )
    path = tmp_path / "kept.json"
    write_episode(run, path, text=TEXT)
    page = open_page(address(map="austin", text="the red bike is near Facebook"))
    settle(page)
    page.set_input_files("#file", path)
    page.locator("#player[data-ended]").wait_for()
    assert page.locator("#map option:checked").inner_text() == "Cleveland"
    page.locator(".play").click()
    line = step_line(page, run.steps)
    assert line.endswith("Found so far: GreenToyota. Found.")
    assert page.locator("#map-a .view path").get_attribute("d").count("M") == run.views[-1].sum()
    belief = run.beliefs[-1]["GreenToyota"]
    strongest = np.unravel_index(np.argmax(drawn_belief(page)[..., 3]), belief.shape)
    assert belief[strongest] == pytest.approx(belief.max(), rel=1e-3)
    with pytest.raises(SystemExit):
        main(["search", TEXT, "--map", "cleveland", "--place", "GreenToyota=27.5,-67.5", "--json"])
    printed = tmp_path / "printed.json"
    printed.write_text(capsys.readouterr().out)
    page.set_input_files("#file", printed)
    page.locator("#map-note", has_text="printed is open. The file keeps no beliefs").wait_for()
    assert step_line(page, run.steps) == line


def test_what_the_page_keeps_it_opens(open_page, tmp_path):
    page = open_page()
    settle(page)
    page.click("#search")
    page.locator("#player[data-ended]").wait_for()
    steps = page.locator("#player").get_attribute("data-ended")
    page.locator("summary", has_text="Keep and share").click()
    with page.expect_download() as kept:
        page.click("#episode")
    path = tmp_path / "mine.json"
    kept.value.save_as(path)
    text = page.input_value("#text")
    other = open_page(address(map="austin", text="the red bike is near Facebook"))
    settle(other)
    other.set_input_files("#file", path)
    other.locator(f"#player[data-ended='{steps}']").wait_for()
    assert other.input_value("#text") == text


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"poses": FLOWN["poses"][:-1]}, "has 4 actions and 4 poses; expected 5"),
        ({"poses": [[0, 0, math.inf]] * 5}, "is not JSON"),
        ({"map": "atlantis"}, "searched on map 'atlantis', which is not here"),
        ({"map_digest": "0" * 16}, "which is not here as it was then"),
        ({"places": {"RedCar": "x"}}, "field 'places'"),
        ({"poses": [[0, 0, 0]] * 2002}, "field 'poses'"),
        ({"views": [[0]] * 5, "shape": [10**6, 10**6]}, "is damaged"),
        ({"views": [[99]] * 5, "shape": [3, 3]}, "is damaged"),
        ({"views": [[1]] * 5, "shape": [3, 3]}, "is of 3 x 3 cells"),
        ({"beliefs": [{"RedCar": [[1.0]]}] * 5, "shape": [2, 2]}, "is damaged"),
        ({"text": "x" * 2001}, "field 'text'"),
    ],
)
def test_what_is_no_episode_is_refused_in_one_line(server, changes, said):
    content = json.dumps({**FLOWN, **changes}).encode()
    status, answer = server.json("POST", "/api/episode?name=f", raw=content)
    assert status == 422
    assert said in answer["error"]
    assert "\n" not in answer["error"]
    assert "/tmp" not in answer["error"]


def test_names_in_an_episode_are_only_texts(open_page, tmp_path):
    evil = "<img src=x onerror=alert(1)>"
    collisions = [{"step": 1, "with": evil}]
    page = open_page()
    settle(page)
    page.set_input_files(
        "#file", flown(tmp_path, collisions=collisions, places={evil: [0, 0]}, detector=evil)
    )
    page.locator("#player[data-ended]").wait_for()
    assert evil in step_line(page, 2)
    assert page.locator("img").count() == 0


def test_a_damaged_file_leaves_the_page_as_it_is(open_page, tmp_path):
    page = open_page(expected=("422",))
    settle(page)
    before = page.url
    page.set_input_files("#file", flown(tmp_path, actions=[]))
    page.locator("#problem", has_text="0 actions and 5 poses").wait_for()
    assert page.url == before
    assert page.locator("#map-note").is_hidden()
