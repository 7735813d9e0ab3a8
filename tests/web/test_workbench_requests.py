"""What the workbench is answered, held against the library."""

from __future__ import annotations

import base64
import json
import socket
import threading
import time
from itertools import pairwise

import numpy as np
import pytest
from support.web_server import TOKEN

import sloop_ppl as sloop
from sloop_ppl.errors import InputError
from sloop_ppl.web._codec import packed_bits, packed_floats
from sloop_ppl.web._maps import MapShelf
from sloop_ppl.web._posteriors import Posteriors
from sloop_ppl.web._state import State

TEXT = "the green toyota is behind velvet dog and the red bike is near a bar"
STATE = {"map": "cleveland", "text": TEXT}


def table(packed, shape):
    """Return a table as the page reads it."""
    shares = np.frombuffer(base64.b64decode(packed["f16"]), "<f2").astype(float)
    return (packed["peak"] * shares).reshape(shape)


def mask(packed, shape):
    bits = np.unpackbits(np.frombuffer(base64.b64decode(packed), np.uint8))
    return bits[: shape[0] * shape[1]].astype(bool).reshape(shape)


def events(server, asked):
    """Return the events of a search."""
    status, headers, content = server.ask("POST", "/api/search", asked)
    assert status == 200, content
    assert headers["content-type"].startswith("text/event-stream")
    return [json.loads(part[6:]) for part in content.decode().split("\n\n") if part]


def test_numbers_survive_the_way():
    rng = np.random.default_rng(0)
    values = 10.0 ** rng.uniform(-9, 0, (7, 5))
    read = table(packed_floats(values), values.shape)
    # float16 has 11 digits of its own above 6e-5 of the peak, then steps of 6e-8 of it.
    assert np.abs(read / values - 1)[values > 1e-4 * values.max()].max() < 2**-11
    assert np.abs(read - values).max() < 2**-11 * values.max()
    assert not table(packed_floats(np.zeros((2, 2))), (2, 2)).any()
    shown = rng.random((7, 5)) < 0.5
    assert (mask(packed_bits(shown), shown.shape) == shown).all()


def test_the_belief_is_that_of_the_library(server):
    _, answer = server.json("POST", "/api/belief", STATE)
    posterior = sloop.infer(TEXT, "cleveland")
    assert [one["id"] for one in answer["belief"]["targets"]] == list(posterior.targets)
    for one in answer["belief"]["targets"]:
        belief = posterior.belief(one["id"])
        read = table(one["belief"], belief.shape)
        assert np.abs(read - belief).max() < 1e-3 * belief.max()
        assert (mask(one["hpd90"], belief.shape) == posterior.hpd(one["id"], 0.9)).all()
        assert (mask(one["hpd50"], belief.shape) == posterior.hpd(one["id"], 0.5)).all()
        assert one["mode_m"] == list(posterior.mode(one["id"]))
    by_phrase = {g.relation.relation: g for g in posterior.grounds("RedBike")}
    (bar,) = answer["belief"]["targets"][1]["referents"]
    assert [c["ground"] for c in bar["candidates"]] == [
        c.ground for c in by_phrase["near"].candidates[:6]
    ]


def test_spans_are_those_of_the_reader(server):
    _, answer = server.json("POST", "/api/belief", STATE)
    marks = {(m["role"], TEXT[slice(*m["span"])]) for m in answer["reading"]["spans"]}
    assert {("figure", "green toyota"), ("relation", "behind"), ("ground", "velvet dog"),
            ("figure", "red bike"), ("relation", "near")} <= marks  # fmt: skip
    spans = [m["span"] for m in answer["reading"]["spans"]]
    assert all(a[1] <= b[0] for a, b in pairwise(spans))


def test_what_is_not_understood_is_said(server):
    state = {**STATE, "text": "the green toyota is near ivy and beside the Zzyzx Palace"}
    _, answer = server.json("POST", "/api/belief", state)
    assert any("Zzyzx" in one["text"] for one in answer["reading"]["unresolved"])
    status, answer = server.json("POST", "/api/belief", {**STATE, "text": "hello there"})
    assert (status, answer["belief"]) == (200, None)
    assert answer["problem"]
    _, answer = server.json("POST", "/api/belief", {**STATE, "text": "  "})
    assert answer == {"reading": None, "belief": None, "problem": ""}


def test_a_phrase_switched_off_is_one_not_said(server):
    text = "the green toyota is behind velvet dog and near ivy"
    _, answer = server.json("POST", "/api/belief", {**STATE, "text": text, "off": [1]})
    (one,) = answer["belief"]["targets"]
    posterior = sloop.infer(text, "cleveland")
    without = posterior.influence("GreenToyota")[1].without
    assert np.abs(table(one["belief"], without.shape) - without).max() < 1e-3 * without.max()
    _, answer = server.json("POST", "/api/belief", {**STATE, "text": text, "off": [0, 1]})
    assert answer["problem"] == "Every phrase is switched off; switch one on"


def test_evidence_is_conditioned_on():
    posteriors = Posteriors(MapShelf().get)
    seen = {"target": "RedBike", "at": (-30.0, 40.0), "radius_m": 20.0}
    base = State("cleveland", "the red bike is near ivy")
    before = posteriors.of(base).posterior

    def after(is_there):
        from sloop_ppl.web._state import Evidence

        state = State(base.map, base.text, evidence=(Evidence(**seen, is_there=is_there),))
        return posteriors.of(state).posterior.belief("RedBike")

    grid = before.city.grid
    near = np.hypot(grid.x_m[None] + 30, grid.y_m[:, None] - 40) <= 20
    belief = before.belief("RedBike")
    for is_there, inside, outside in ((False, 0.05, 0.98), (True, 0.95, 0.02)):
        by_hand = belief * np.where(near, inside, outside)
        assert np.allclose(after(is_there), by_hand / by_hand.sum())


def test_an_area_bounds_the_belief(server):
    state = {**STATE, "text": "the red bike is near ivy", "area": [-100, 0, 0, 100]}
    _, answer = server.json("POST", "/api/belief", state)
    (one,) = answer["belief"]["targets"]
    grid = sloop.load_map("cleveland").grid
    belief = table(one["belief"], grid.shape)
    assert belief[:, grid.x_m > 0].sum() == 0
    assert belief[grid.y_m < 0].sum() == 0
    assert table(one["prior"], grid.shape)[:, grid.x_m > 0].sum() == 0


def test_a_place_off_the_map_is_refused(server):
    evidence = [{"target": "GreenToyota", "at": [900, 0]}]
    status, answer = server.json("POST", "/api/belief", {**STATE, "evidence": evidence})
    assert status == 422
    assert "outside the map" in answer["error"]


def test_why_tells_influence_and_what_each_phrase_says_of_a_place(server):
    asked = {"state": STATE, "target": "GreenToyota", "at": [-47.5, -62.5]}
    _, answer = server.json("POST", "/api/why", asked)
    posterior = sloop.infer(TEXT, "cleveland")
    (phrase,) = answer["phrases"]
    assert phrase["bits"] == pytest.approx(posterior.influence("GreenToyota")[0].bits)
    cell = posterior.city.grid.cell_at(-47.5, -62.5)
    times = posterior.phrase_tables("GreenToyota")[0][cell] * posterior.city.grid.size
    assert phrase["times"] == pytest.approx(times)
    assert answer["p"] == pytest.approx(posterior.belief("GreenToyota")[cell])
    assert sum(answer["components"].values()) == pytest.approx(1)


def test_frames_are_those_of_the_library(server):
    _, answer = server.json("POST", "/api/frames-of", STATE)
    found = sloop.infer(TEXT, "cleveland").frames("GreenToyota")
    assert [f["angle_rad"] for f in answer["GreenToyota"]] == [f.mean_rad for f in found]
    assert [f["p"] for f in answer["GreenToyota"]] == [f.p for f in found]


def test_the_search_is_that_of_the_library(server):
    text, place = "the green toyota is behind velvet dog", (-47.5, -62.5)
    asked = {"state": {**STATE, "text": text}, "places": {"GreenToyota": place}, "seed": 3}
    first, *steps, last = events(server, asked)
    episode = sloop.search(
        sloop.infer(text, "cleveland"), sloop.load_map("cleveland"), {"GreenToyota": place},
        rng=np.random.default_rng(3), keep_beliefs=True,
    )  # fmt: skip
    assert last["kind"] == "end"
    assert [s["action"] for s in steps] == list(episode.actions)
    assert first["pose"] == list(episode.poses[0])
    assert [s["pose"] for s in steps] == [list(pose) for pose in episode.poses[1:]]
    assert last["episode"] == {**json.loads(json.dumps(episode.to_json())), "map": "cleveland",
                               "planner": "fast", "seed": 3}  # fmt: skip
    shape = episode.views[0].shape
    for step, view, beliefs in zip(steps, episode.views[1:], episode.beliefs[1:], strict=True):
        assert (mask(step["view"], shape) == view).all()
        belief = beliefs["GreenToyota"]
        read = table(step["beliefs"]["GreenToyota"], shape)
        assert np.abs(read - belief).max() < 1e-3 * belief.max()


def test_an_imagined_place_is_told_and_can_be_kept(server):
    asked = {"state": {**STATE, "text": "the red bike is near ivy"}, "seed": 1}
    first = events(server, asked)[0]
    assert first["imagined"] == ["RedBike"]
    later = {**asked, "places": first["places"], "utterances": [[2, "it is north of ivy"]]}
    again = events(server, later)[0]
    assert (again["places"], again["imagined"]) == (first["places"], [])


def test_what_is_said_later_leaves_the_steps_before_alone(server):
    asked = {"state": {**STATE, "text": "the red bike is near ivy"},
             "places": {"RedBike": [-82.5, 2.5]}}  # fmt: skip
    plain = events(server, asked)
    told = events(server, {**asked, "utterances": [[4, "it is south of the bradley"]]})
    assert [s["action"] for s in told[1:5]] == [s["action"] for s in plain[1:5]]
    assert told[4]["beliefs"] != plain[4]["beliefs"]


def test_a_mistake_in_a_search_is_told_in_the_stream(server):
    asked = {"state": STATE, "start": [1000, 0]}
    *_, last = events(server, asked)
    assert last["kind"] == "error"
    assert "outside the map" in last["error"]
    status, _ = server.json("POST", "/api/search", {"state": STATE, "planner": "x.py:Y"})
    assert status == 422


def running_searches(server):
    """Return how many searches the server could not start any more."""
    import multiprocessing

    return len(multiprocessing.active_children())


def begin_search(server):
    """Return a connection over which a long search has begun to come."""
    body = json.dumps(
        {"state": {**STATE, "text": "the red bike is near ivy"}, "planner": "pouct", "sims": 10_000,
         "places": {"RedBike": [97.5, -97.5]}, "steps": 1000}
    ).encode()  # fmt: skip
    connection = socket.create_connection(("127.0.0.1", server.port), timeout=60)
    connection.sendall(
        f"POST /api/search HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
        f"Authorization: Bearer {TOKEN}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n".encode()
        + body
    )
    while b'"kind": "start"' not in connection.recv(65536):
        pass
    return connection


def test_a_search_ends_when_the_page_leaves(server):
    connection = begin_search(server)
    assert running_searches(server) == 1
    connection.close()
    for _ in range(600):
        if not running_searches(server):
            break
        time.sleep(0.1)
    assert running_searches(server) == 0


def test_a_search_keeps_no_one_from_reading(server):
    connection = begin_search(server)
    try:
        for i in range(5):
            state = {**STATE, "text": TEXT + " " * i}
            assert server.json("POST", "/api/belief", state)[0] == 200
        assert running_searches(server) == 1
    finally:
        connection.close()


def test_many_at_once_get_what_each_alone_would(server):
    texts = [f"the red bike is {word} {place}" for word in ("near", "behind", "north of", "at")
             for place in ("ivy", "velvet dog", "the hat factory")]  # fmt: skip
    alone = [server.json("POST", "/api/belief", {**STATE, "text": t})[1] for t in texts]
    found = [None] * len(texts)

    def ask(i):
        # A blank more: it is not what was kept from before.
        state = {**STATE, "text": texts[i] + " "}
        found[i] = server.json("POST", "/api/belief", state)[1]

    threads = [threading.Thread(target=ask, args=(i,)) for i in range(len(texts))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [one["belief"] for one in found] == [one["belief"] for one in alone]


def test_files_are_those_of_the_library(server, tmp_path):
    posterior = sloop.infer(TEXT, "cleveland")
    status, headers, content = server.ask("POST", "/api/export/netcdf", STATE)
    assert (status, headers["content-disposition"]) == (200, 'attachment; filename="posterior.nc"')
    (tmp_path / "posterior.nc").write_bytes(content)
    loaded = sloop.Posterior.load(tmp_path / "posterior.nc")
    assert (loaded.belief("RedBike") == posterior.belief("RedBike")).all()
    _, geojson = server.json("POST", "/api/export/geojson", STATE)
    assert geojson == json.loads(json.dumps(posterior.to_geojson()))
    assert server.ask("POST", "/api/export/png", STATE)[2].startswith(b"\x89PNG")
    assert server.ask("POST", "/api/export/exe", STATE)[0] == 404


def test_a_map_of_ones_own_is_known_by_its_digest(tmp_path):
    from sloop_ppl.maps import write_map

    write_map(sloop.load_map("austin").window((0, 0), 100), tmp_path / "small.geojson")
    shelf = MapShelf([str(tmp_path / "small.geojson")])
    city = shelf.get(shelf.first)
    assert shelf.first == city.digest
    key, note = shelf.take_in((tmp_path / "small.geojson").read_bytes(), city.name)
    assert (key, note) == (city.digest, "")


def test_too_large_a_map_is_refused_or_cut(tmp_path):
    from sloop_ppl.maps import Grid, write_map

    city = sloop.load_map("cleveland")
    grid = city.grid
    wide = city.with_grid(Grid(-100, -100, 100, 100, 0.4, grid.centre))
    path = tmp_path / "fine.geojson"
    write_map(wide, path)
    with pytest.raises(InputError, match="the workbench takes 160000 at most"):
        MapShelf([str(path)])


def test_the_first_page_shows_something_on_any_map(tmp_path):
    from sloop_ppl.maps import bundled_maps
    from sloop_ppl.web._examples import first_state

    posteriors = Posteriors(MapShelf().get)
    for name in bundled_maps():
        first = first_state(MapShelf([name]))
        assert first["map"] == name
        found = posteriors.of(State(name, first["text"]))
        assert set(first["places"]) <= set(found.posterior.targets)
