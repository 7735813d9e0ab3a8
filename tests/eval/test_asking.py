"""Sweeps that ask: fair answerers, what is held back, and what the report says of it."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
import shapely

from sloop_ppl.bridge.asking import ask
from sloop_ppl.cli import main
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import bundled_examples
from sloop_ppl.eval._answerers import (
    AskingSettings,
    OracleAnswerer,
    PersonAnswerer,
    RecordedAnswerer,
    held_back,
    meant,
    recorded_relations,
    speaker_place,
    without,
)
from sloop_ppl.eval._question_summary import question_summary, question_table
from sloop_ppl.eval.results import read_results
from sloop_ppl.eval.trials import Trial, TrialKey
from sloop_ppl.inference import infer_description
from sloop_ppl.maps import CityMap, Landmark, load_map
from sloop_ppl.rng import child
from tests.scenes import relation, said, symmetric_grid

EXAMPLES = bundled_examples()
LINE = next(line for line in EXAMPLES if any(len(line.about(t)) > 1 for t in line.targets))
TARGET = next(t for t in LINE.targets if len(LINE.about(t)) > 1)
CITY = load_map(LINE.map)


def posterior(description=None):
    return infer_description(description or LINE.description(CITY), CITY, "bayes")[0]


def rng(n=0):
    return child(np.random.default_rng(n), "person")


def asked(kinds=("side", "nearer", "distance"), n=12):
    return ask(posterior(), CITY, n, target=TARGET, kinds=list(kinds))


def test_the_oracle_is_right_but_for_its_errors():
    cell = LINE.targets[TARGET].cell
    right = {"error": 0.0, "guess": 0.0}
    for question in asked():
        true = question.options[meant(question, LINE, cell)]
        assert OracleAnswerer(LINE, TARGET, cell, rng=rng(), **right).answer(question) == true
    question = asked(n=1)[0]
    true = question.options[meant(question, LINE, cell)]
    given = [
        OracleAnswerer(LINE, TARGET, cell, error=0.25, guess=0.0, rng=rng(n)).answer(question)
        for n in range(400)
    ]
    share = sum(answer != true for answer in given) / 400
    assert abs(share - 0.25) < 5 * np.sqrt(0.25 * 0.75 / 400)  # once in a million runs


@pytest.mark.parametrize("make", [OracleAnswerer, PersonAnswerer])
def test_all_models_meet_the_same_person(make):
    """An answer depends on description, target and question alone, not on what was asked before."""
    place = LINE.targets[TARGET]

    def person():
        if make is OracleAnswerer:
            return OracleAnswerer(LINE, TARGET, place.cell, error=0.4, guess=0.1, rng=rng())
        return PersonAnswerer(LINE, TARGET, (place.x_m, place.y_m), CITY, error=0.4, rng=rng())

    questions = asked()
    first = person()
    forwards = [first.answer(q) for q in questions]
    second = person()
    backwards = [second.answer(q) for q in reversed(questions)]
    assert forwards == backwards[::-1]
    other = infer_description(LINE.description(CITY), CITY, "sloop-m4")[0]
    same = {q.text: q for q in ask(other, CITY, 40, target=TARGET)}
    for question, answer in zip(questions, forwards, strict=True):
        if question.text in same:
            assert person().answer(same[question.text]) == answer


def test_errors_of_a_person_persist_over_the_questions_about_a_landmark():
    place = LINE.targets[TARGET]
    person = PersonAnswerer(LINE, TARGET, (place.x_m, place.y_m), CITY, error=0.0, rng=rng(3))
    (landmark,) = asked(("side",), 1)[0].landmarks
    assert person._seen(landmark) == person._seen(landmark)
    true = np.hypot(*np.subtract((place.x_m, place.y_m), CITY.centroid(landmark)))
    seen = [
        PersonAnswerer(LINE, TARGET, (place.x_m, place.y_m), CITY, error=0, rng=rng(n))._seen(
            landmark
        )[0]
        for n in range(200)
    ]
    assert abs(np.mean(np.log(np.array(seen) / true))) < 5 * 0.3 / np.sqrt(200)


def quiet_person(places, at):
    """Return a toy map, and a person who stands there, sees exactly and knows all."""
    where = CityMap("toy", symmetric_grid(21), places)
    person = PersonAnswerer(LINE, "RedCar", at, where, error=0.0, rng=rng())
    person.ANGLE_DEG = person.DISTANCE_SHARE = person.MOST_UNKNOWN = 0.0
    return where, person


def test_a_person_is_inside_a_footprint_not_inside_the_box_around_it():
    corner = shapely.Polygon([(0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (0, 40)])
    for at, answer in (((5.0, 30.0), "inside"), ((30.0, 30.0), "outside")):
        where, person = quiet_person((Landmark("L", "building", corner, name="The Bend"),), at)
        nothing = infer_description(said(relation("near", "L")), where, "uniform")[0]
        (question,) = ask(nothing, where, 1, kinds=["inside"])
        assert person.answer(question) == answer


def test_a_person_knows_all_parts_of_a_street_and_others():
    def way(name, at, *ends):
        return Landmark(at, "street", shapely.LineString(ends), name=name)

    places = (
        way("Main Street", "MainWest", (-50, 0), (-10, 0)),
        way("Main Street", "MainEast", (10, 0), (50, 0)),
        way("High Street", "High", (-50, 40), (50, 40)),
        way("Low Street", "Low", (-50, -45), (-20, -45)),
    )
    prior = np.zeros((21, 21))
    prior[8:18] = 1 / 210  # next to nothing of it by Low Street
    for at, answer in (((40.0, 6.0), "Main Street"), ((-40.0, -44.0), "another one")):
        where, person = quiet_person(places, at)
        nothing = infer_description(said(relation("near", "High")), where, "uniform", prior=prior)
        (question,) = ask(nothing[0], where, 1, kinds=["street"])
        assert set(question.options) == {"Main Street", "High Street", "another one"}
        assert person.answer(question) == answer


def test_slips_are_of_the_oracle_unless_they_are_asked_for():
    assert [AskingSettings(answerer=kind).slips for kind in "ab"] == [0.1, 0.0]
    assert AskingSettings(answerer="b").person.error == 0.1
    slipping = AskingSettings(answerer="b", error=0.3)
    assert slipping.slips == slipping.person.error == 0.3
    assert AskingSettings(answerer="b", error=0.3, believed_error=0.2).person.error == 0.2


def test_a_speaker_who_is_right_thinks_the_target_where_it_is():
    places = [
        speaker_place(line, target, load_map(line.map)) == (place.x_m, place.y_m)
        for line in EXAMPLES[:6]
        for target, place in line.targets.items()
    ]
    assert np.mean(places) > 0.6
    x, y = LINE.targets[TARGET].x_m, LINE.targets[TARGET].y_m
    cell = CITY.grid.cell_at(-x, -y)
    wrong = replace(LINE.targets[TARGET], x_m=-x, y_m=-y, cell=cell)
    mistaken = replace(LINE, targets={**LINE.targets, TARGET: wrong})
    assert speaker_place(mistaken, TARGET, CITY) != (-x, -y)


def test_what_is_held_back_is_not_told_and_is_answered():
    held = held_back(LINE, 0)
    relation = held[TARGET]
    assert relation in LINE.about(TARGET)
    assert held == held_back(LINE, 0)
    told = without(LINE.description(CITY), [relation])
    assert relation not in told.relations
    assert len(told.relations) == len(LINE.relations) - 1
    recorded = recorded_relations(LINE, EXAMPLES, 0)[TARGET]
    assert recorded[0] == relation
    assert not set(recorded[1:]) & set(LINE.about(TARGET))
    answerer = RecordedAnswerer((relation,), LINE.description(CITY))
    grounds = [g for g in relation.grounds if g in CITY]
    before = posterior(told)
    (question,) = ask(before, CITY, 1, target=TARGET, kinds=["distance"], landmarks=grounds)
    after = before.update(answerer.answer(question))
    whole = posterior().belief(TARGET)
    gap = [np.abs(p.belief(TARGET) - whole).sum() for p in (before, after)]
    assert gap[1] < gap[0]
    other = [m.id for m in CITY.landmarks if m.name and m.id not in relation.grounds][:1]
    (strange,) = ask(before, CITY, 1, target=TARGET, kinds=["distance"], landmarks=other)
    assert answerer.answer(strange) == "I don't know"


def test_a_sweep_that_asks_goes_on_and_reports(tmp_path, capsys):
    lines = (tmp_path / "few.jsonl", tmp_path / "run")
    source = (files("sloop_ppl") / "data" / "examples.jsonl").read_text().splitlines()
    lines[0].write_text("\n".join(source[:2]) + "\n")
    command = [
        "eval", "search", str(lines[0]), "--out", str(lines[1]), "--models", "bayes,uniform",
        "--ranges", "3", "--sims", "60", "--steps", "30", "--workers", "1",
        "--questions", "0,1", "--question-cost", "10,30",
    ]  # fmt: skip
    for _ in range(2):
        with pytest.raises(SystemExit) as ended:
            main(command)
        assert ended.value.code == 0
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main(["eval", "report", str(lines[1]), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert set(told["questions"]) == {"bayes", "uniform"}
    one, none = told["questions"]["bayes"]["1"], told["questions"]["bayes"]["0"]
    assert {"n", "net", "gross", "asked", "ci95"} <= set(one)
    assert (none["net"], none["asked"]) == (0.0, 0.0)
    assert one["n"] == none["n"] == told["models"]["bayes"]["3"]["n"]
    assert one["gross"] - one["net"] == pytest.approx(10 * one["asked"])
    assert list(one["costs"]) == ["30"]
    results = read_results(lines[1])
    assert question_summary(results)["bayes"]["1"]["net"] == one["net"]
    assert len(question_table(results).rows) == 6
    quiet = [t for t in results.trials if t.key.questions == 0]
    assert all(t.asked == 0 and t.gross_reward == t.discounted_reward for t in quiet)
    with pytest.raises(SystemExit) as ended:
        main([*command[:-1], "10"])
    assert ended.value.code == 2
    assert "holds another sweep" in capsys.readouterr().err


def test_a_sweep_reports_where_some_targets_have_nothing_to_hold_back(tmp_path, capsys):
    counts = {line.id: [len(line.about(t)) for t in line.targets] for line in EXAMPLES}
    few = next(
        line.id for line, n in zip(EXAMPLES, counts.values(), strict=True) if min(n) == 1 < max(n)
    )
    source = (files("sloop_ppl") / "data" / "examples.jsonl").read_text().splitlines()
    (tmp_path / "few.jsonl").write_text(next(one for one in source if json.loads(one)["id"] == few))
    command = [
        "eval", "search", str(tmp_path / "few.jsonl"), "--out", str(tmp_path / "run"), "--models",
        "uniform", "--ranges", "3", "--sims", "20", "--steps", "5", "--workers", "1",
        "--questions", "0,1", "--answerer", "c",
    ]  # fmt: skip
    for arguments in (command, ["eval", "report", str(tmp_path / "run"), "--json"]):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        out, err = capsys.readouterr()
        assert ended.value.code == 0, err
    told = json.loads(out)["questions"]["uniform"]
    assert told["1"]["n"] == sum(n > 1 for n in counts[few])


def test_a_trial_without_questions_is_read_from_an_older_file():
    key = TrialKey("d", "T", "bayes", 3.0, 1)
    trial = Trial(key, "m", "c", True, 5, 50.0, 60.0, (0.0, 1.0), 0.1)
    record = trial.to_json()
    for name in ("questions", "question_cost", "asked", "gross_reward", "expected_bits",
                 "realised_bits", "log_score"):  # fmt: skip
        del record[name]
    assert Trial.from_json(record) == trial
    told = replace(trial, asked=1, gross_reward=3.0, log_score=-2.0, expected_bits=1.5)
    assert Trial.from_json(told.to_json()) == told


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ({"answerer": "d"}, UnknownName),
        ({"choice": "best"}, UnknownName),
        ({"rho": 1.5}, InputError),
        ({"error": 1.0}, InputError),
        ({"believed_guess": 2.0}, InputError),
    ],
)
def test_settings_that_cannot_be(values, kind):
    with pytest.raises(kind):
        AskingSettings(**values)
