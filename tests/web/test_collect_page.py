"""Collecting descriptions: who gets which map, what is saved, and what becomes of it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from support.web_server import GUEST, TOKEN, running

import sloop_ppl as sloop
from sloop_ppl._journal import Journal
from sloop_ppl.errors import InputError
from sloop_ppl.eval import read_descriptions
from sloop_ppl.web import Study, export_answers, prepare_study
from sloop_ppl.web._assignment import Assignment
from sloop_ppl.web.application import WebSettings

pytestmark = pytest.mark.xdist_group("chromium")

TEXT = "The {0} is near Ivy, and the {1} is on West 6th Street."


def small_study(count=2, people=2):
    return prepare_study(["cleveland"], count, people, rng=np.random.default_rng(0))


@pytest.fixture
def collecting(tmp_path):
    settings = WebSettings(
        token=TOKEN, guest_token=GUEST, folder=tmp_path / "kept", study=small_study()
    )
    with running(settings) as served:
        yield served


def records(server):
    return Journal(server.settings.folder / "descriptions.jsonl").records()


def test_configurations_are_drawn_in_the_open_and_apart():
    study = prepare_study(["cleveland", "denver"], 12, 3, rng=np.random.default_rng(1), seed=1)
    assert [len({c.id for c in study.configurations}), study.people] == [24, 3]
    for one in study.configurations:
        city = sloop.load_map(one.map)
        (a, b) = one.targets.values()
        assert np.hypot(a[0] - b[0], a[1] - b[1]) >= 20
        for x, y in (a, b):
            cell = city.grid.cell_at(x, y)
            assert not any(city.cells(m.id)[cell] for m in city.of_kind("building", "water"))
    again = prepare_study(["cleveland", "denver"], 12, 3, rng=np.random.default_rng(1), seed=1)
    assert again == study
    # A map's configurations do not depend on which others there are.
    alone = prepare_study(["denver"], 12, 3, rng=np.random.default_rng(1))
    assert alone.configurations == study.configurations[12:]


def test_a_study_is_read_back_and_checked(tmp_path):
    path = tmp_path / "study.json"
    study = small_study()
    study.save(path)
    assert Study.load(path) == study
    path.write_text('{"people": 0, "configurations": []}')
    with pytest.raises(InputError, match="field 'people' is 0; expected a number of at least 1"):
        Study.load(path)
    far = {"id": "a", "map": "cleveland", "targets": {"RedBike": [1e5, 0]}}
    path.write_text(json.dumps({"people": 1, "configurations": [far]}))
    with pytest.raises(InputError, match="outside the map"):
        Study.load(path)
    path.write_text(json.dumps({"people": 1, "configurations": [{**far, "targets": {}}] * 2}))
    with pytest.raises(InputError, match="two configurations of one id"):
        Study.load(path)


def test_each_is_described_by_a_few_and_by_nobody_twice():
    """Ten people, of whom each wants all: 3 configurations of 4 people are 12 descriptions."""
    study = small_study(3, 4)
    assignment, records = Assignment(study), []
    for _ in range(5):
        for person in (f"person-{i}" for i in range(10)):
            found = assignment.next_for(person, records)
            if found is not None:
                records.append({"text": "x", "configuration": found.id, "speaker": person})
                assignment.release(person)
    pairs = [(r["configuration"], r["speaker"]) for r in records]
    assert len(set(pairs)) == len(pairs) == 12
    counts = [sum(c == one.id for c, _ in pairs) for one in study.configurations]
    assert counts == [4, 4, 4]


def test_what_is_held_is_not_given_to_others_until_it_is_given_up():
    now = [0.0]
    assignment = Assignment(small_study(1, 1), clock=lambda: now[0])
    first = assignment.next_for("person-a", [])
    assert assignment.next_for("person-a", []) == first  # a page loaded again
    assert assignment.next_for("person-b", []) is None
    now[0] = 31 * 60.0
    assert assignment.next_for("person-b", []) == first


def test_a_description_is_collected_and_corrected(open_page, collecting, picture):
    page = open_page("/collect", base=collecting.url, token=GUEST, expected=("401",))
    assert page.locator("#begin").is_disabled()
    picture(page, "collect-example-light")
    page.check("#consent")
    page.click("#begin")
    page.locator(".object").nth(1).wait_for()
    assert page.locator("#pages").is_hidden()  # who is invited sees no other page
    names = [n.inner_text() for n in page.locator("#objects b").all()]
    study = {c.id: c for c in collecting.settings.study.configurations}
    placed = page.locator("svg.map .object").evaluate_all(
        """nodes => nodes.map(n => {
            const m = n.getScreenCTM(), r = n.ownerSVGElement.getScreenCTM();
            const p = new DOMPoint(m.e, m.f).matrixTransform(r.inverse());
            return [n.dataset.object, p.x, -p.y]; })"""
    )
    page.fill("#text", TEXT.format(*(n.removeprefix("the ") for n in names)))
    page.locator("#hint li").nth(1).wait_for()
    assert "near Ivy" in page.inner_text("#hint")
    assert "(" not in page.inner_text("#hint")
    picture(page, "collect-light")
    page.locator("summary").click()
    page.fill("#second", "somewhere else entirely")
    page.click("#save")
    page.locator("#count", has_text="You have described 1 so far").wait_for()
    first, second = records(collecting)
    one = study[first["configuration"]]
    for name, x, y in placed:
        assert (x, y) == pytest.approx(one.targets[name], abs=0.1)
    assert {k: (v["east_m"], v["north_m"]) for k, v in first["targets"].items()} == one.targets
    assert [r["relation"] for r in first["relations"]] == ["near", "on"]
    assert (first["checked"], second["relations"]) == (False, [])
    assert first["speaker"] == second["speaker"]
    assert first["id"] != second["id"]
    page.click("#skip")
    page.locator("#thanks", has_text="There is no map left for you").wait_for()

    desk = open_page("/progress", base=collecting.url)
    assert "2 descriptions" in desk.inner_text("#summary")
    card = desk.locator(f".answer[data-id='{first['id']}']")
    card.get_by_label("relation", exact=True).first.select_option("behind")
    card.get_by_label("denied").nth(1).check()
    picture(desk, "progress-light")
    card.get_by_text("Save as checked").click()
    desk.locator(f".answer[data-id='{first['id']}'] .checked").wait_for()
    desk.check("#only")
    assert desk.locator(".answer").count() == 1

    path = collecting.settings.folder / "descriptions.jsonl"
    out = path.with_name("out.jsonl")
    assert export_answers(path, out) == 2
    gold, raw = read_descriptions([out])
    assert [r.relation for r in gold.relations] == ["behind", "on"]
    assert [r.negated for r in gold.relations] == [False, True]
    assert (gold.has_gold, raw.has_gold) == (True, False)
    assert "consent" not in out.read_text()
    assert export_answers(path, out, only_checked=True) == 1
    export_answers(path, out, parsed=True)
    assert [one.has_gold for one in read_descriptions([out])] == [True, True]


def test_nothing_is_saved_without_consent_or_twice(collecting):
    person = collecting.json("POST", "/api/collect/guest/join", {})[1]["person"]
    found = collecting.json("POST", "/api/collect/guest/next", {"person": person})[1]
    given = {"person": person, "configuration": found["configuration"], "texts": ["near ivy"]}

    def save(**changes):
        body = {**given, "consent": True, **changes}
        return collecting.json("POST", "/api/collect/guest/descriptions", body, token=GUEST)[0]

    assert save(consent=False) == 422
    assert save(texts=[" "]) == 400
    assert save(texts=["a"] * 3) == 400
    assert save(person="../../x") == 400
    assert save(configuration="none") == 404
    assert records(collecting) == []
    assert save() == 200
    assert save() == 409
    assert len(records(collecting)) == 1


def test_a_correction_must_be_of_the_map_and_the_objects(collecting):
    person = collecting.json("POST", "/api/collect/guest/join", {})[1]["person"]
    found = collecting.json("POST", "/api/collect/guest/next", {"person": person})[1]
    collecting.json(
        "POST", "/api/collect/guest/descriptions",
        {"person": person, "configuration": found["configuration"], "texts": ["x"],
         "consent": True},
    )  # fmt: skip
    name = records(collecting)[0]["id"]
    good = {"figure": found["objects"][0]["id"], "relation": "near", "ground": "Ivy"}
    for bad in ({"figure": "X"}, {"relation": "nigh"}, {"ground": "X"}):
        body = {"id": name, "relations": [{**good, **bad}]}
        assert collecting.ask("POST", "/api/collect/corrections", body)[0] == 422
    assert (
        collecting.ask("POST", "/api/collect/corrections", {"id": "x", "relations": []})[0] == 404
    )
    body = {"id": name, "relations": [good]}
    assert collecting.ask("POST", "/api/collect/corrections", body, token=GUEST)[0] == 401
    assert collecting.ask("POST", "/api/collect/corrections", body)[0] == 200


def test_the_commands_make_and_export_a_study(tmp_path, capsys, monkeypatch):
    from sloop_ppl.cli import main

    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main(arguments)
        return end.value.code, capsys.readouterr()

    code, shown = run(
        "collect", "prepare", "--maps", "denver", "--per-map", "3", "--out", "s.json", "--json"
    )
    assert (code, json.loads(shown.out)) == (
        0, {"out": "s.json", "configurations": 3, "people": 5},
    )  # fmt: skip
    code, shown = run("collect", "export", "none.jsonl", "--out", "o.jsonl")
    assert code == 2
    assert shown.err.startswith("sloop: Answers file 'none.jsonl' cannot be read")
    code, shown = run("serve", "--port", "8765", "--map", "atlantis")
    assert code == 2
    assert "Map 'atlantis' is unknown" in shown.err
