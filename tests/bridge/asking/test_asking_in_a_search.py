"""Questions during a search: who answers, what it costs, and that it goes on whatever happens."""

from __future__ import annotations

import json
import queue
import threading

import numpy as np
import pytest

import sloop_ppl as sloop
from sloop_ppl.bridge.asking import (
    AnswererModel,
    Dialogue,
    FileAnswerer,
    QueueAnswerer,
    SimulatedAnswerer,
    TerminalAnswerer,
    ask,
    converse,
)
from sloop_ppl.errors import InputError
from sloop_ppl.planning import read_episode, write_episode

CITY = sloop.load_map("cleveland")
TEXT = "the red bike is by the bar"
PLACE = {"RedBike": (12.0, 30.0)}  # by the other bar than the one that is read
START = (-60.0, -60.0)


class Scripted:
    """Answers with what it is given, and keeps what it was asked."""

    def __init__(self, *answers):
        self.answers, self.asked = list(answers), []

    def answer(self, question):
        self.asked.append(question)
        answer = self.answers.pop(0) if self.answers else None
        if isinstance(answer, Exception):
            raise answer
        return answer


@pytest.fixture(scope="module")
def posterior():
    return sloop.infer(TEXT, CITY)


def search(posterior, answerer, planner="fast", sims=200, seed=0, told=None, **dialogue):
    return sloop.search(
        posterior, CITY, PLACE, planner=planner, sims=sims, start=START,
        rng=np.random.default_rng(seed), notify=None if told is None else told.append,
        dialogue=None if answerer is None else Dialogue(answerer, **dialogue),
    )  # fmt: skip


def oracle(error=0.0):
    return SimulatedAnswerer(PLACE, error=error, rng=np.random.default_rng(7))


def test_a_search_asks_and_mends_what_was_misread(posterior):
    person = AnswererModel.exact(0.1)
    episode = search(posterior, oracle(), most=2, cost=10.0, person=person)
    assert len(episode.questions) == 2
    assert all(q.gain > 0 for q in episode.questions)
    assert [q.step for q in episode.questions] == [0, 0]
    ground = posterior.grounds("RedBike")[0]
    assert ground.relation.ground == "Ivy"
    after = {c.ground: c.p for c in episode.posterior.grounds("RedBike")[0].candidates}
    assert after["BarleyHouse"] > 0.8
    assert len(episode.posterior.answers) == 2
    quiet = search(posterior, None)
    assert episode.discounted_return > quiet.discounted_return


def test_the_return_counts_costs_and_delays_by_hand(posterior):
    episode = search(posterior, oracle(), most=1, cost=10.0, steps=2)
    (asked,) = episode.questions
    assert (asked.step, asked.cost, asked.steps) == (0, 10.0, 2)
    gross = sum(0.95 ** (t + 2) * r for t, r in enumerate(episode.rewards))
    assert episode.gross_discounted_return == pytest.approx(gross)
    assert episode.discounted_return == pytest.approx(gross - 10)
    assert episode.undiscounted_return == pytest.approx(sum(episode.rewards) - 10)


@pytest.mark.parametrize("planner", ["fast", "pouct", "pomcp"])
def test_what_is_too_dear_is_not_asked(posterior, planner):
    answerer = Scripted()
    episode = search(posterior, answerer, planner, most=2, cost=5000.0)
    assert episode.questions == ()
    assert answerer.asked == []
    same = search(posterior, None, planner)
    if planner == "fast":  # the trees of the others have other actions, so other draws
        assert episode.actions == same.actions


@pytest.mark.parametrize("planner", ["pouct", "pomcp"])
def test_the_tree_searches_have_asking_as_an_action(posterior, planner):
    episode = search(posterior, oracle(), planner, sims=400, most=2, cost=0.0)
    offered = any(name.startswith("ask(") for info in episode.info for name in info.visits)
    assert offered or len(episode.questions) == 2
    assert len(episode.questions) <= 2
    told = episode.to_json().get("questions", [])
    assert [q["text"] for q in told] == [q.text for q in episode.questions]
    assert episode.found


def test_answers_that_are_known_to_be_guessed_are_not_asked_for(posterior):
    answerer = Scripted()
    search(posterior, answerer, most=2, cost=1.0, person=AnswererModel(guess=1.0))
    assert answerer.asked == []


def test_a_question_is_not_asked_twice(posterior):
    answerer = Scripted(*["I don't know"] * 5)
    search(posterior, answerer, most=5, cost=0.0)
    texts = [question.text for question in answerer.asked]
    assert len(texts) == len(set(texts)) == 5


@pytest.mark.parametrize(
    ("answer", "note", "more"),
    [
        (RuntimeError("line is dead"), "no answer: line is dead", 1),
        (None, "no answer", 1),
        ("blue", "not understood", 2),
    ],
)
def test_the_search_goes_on_without_an_answer(posterior, answer, note, more):
    answerer, told = Scripted(answer), []
    episode = search(posterior, answerer, most=2, cost=1.0, told=told)
    assert episode.questions[0].note == note
    assert episode.questions[0].realised == 0.0
    assert len(answerer.asked) == more
    assert episode.steps > 0
    assert any("the search goes on" in line for line in told)


def test_of_two_sure_answers_that_contradict_each_other_one_is_doubted(posterior):
    sure, told = AnswererModel.exact(0.0), []
    (side,) = ask(posterior, CITY, 1, kinds=["side"], landmarks=["BarleyHouse"], person=sure)
    west = posterior.update(side.answer("west"))
    (far,) = ask(west, CITY, 1, kinds=["side"], landmarks=["WaringBlock"], person=sure)
    contradicted = west.update(far.answer("east"))
    assert [c.p < 0.5 for c in contradicted.checked_answers()].count(True) == 1
    answerer = Scripted("east")
    episode = sloop.search(
        west, CITY, PLACE, start=START, rng=np.random.default_rng(0), notify=told.append,
        dialogue=Dialogue(
            answerer, cost=0.0, person=sure, kinds=("side",), landmarks=("WaringBlock",)
        ),
    )  # fmt: skip
    if episode.questions:
        assert any("doubted" in line for line in told)
    assert episode.steps > 0


def test_the_same_seed_gives_the_same_episode(posterior, tmp_path):
    written = []
    for name in ("a.json", "b.json"):
        episode = search(posterior, oracle(0.2), most=2)
        write_episode(episode, tmp_path / name)
        written.append((tmp_path / name).read_bytes())
    assert written[0] == written[1]
    again = read_episode(tmp_path / "a.json")
    assert again.questions == episode.questions
    assert again.discounted_return == episode.discounted_return
    damaged = json.loads(written[0])
    damaged["questions"][0]["cost"] = -1
    (tmp_path / "c.json").write_text(json.dumps(damaged))
    with pytest.raises(InputError, match="The episode is damaged"):
        read_episode(tmp_path / "c.json")


def test_one_target_after_the_other_shares_the_questions():
    two = sloop.infer("the red bike is by the bar. The green toyota is near the bank", CITY)
    places = {"RedBike": (12.0, 30.0), "GreenToyota": (40.0, 40.0)}
    answerer = Scripted(*["I don't know"] * 9)
    episode = sloop.search(
        two, CITY, {t: places[t] for t in two.targets}, sims=100, start=START,
        rng=np.random.default_rng(0), one_at_a_time=True,
        dialogue=Dialogue(answerer, most=3, cost=0.0),
    )  # fmt: skip
    assert len(episode.questions) <= 3
    assert [q.step for q in episode.questions] == sorted(q.step for q in episode.questions)


def test_a_person_at_the_terminal(posterior):
    lines, shown = iter(["purple", "north"]), []
    person = TerminalAnswerer(lambda: next(lines), shown.append)
    (question,) = ask(posterior, CITY, 1, kinds=["side"])
    assert person.answer(question) == "north"
    assert shown[0] == question.text
    assert shown[1].startswith("Answer 'purple' was not understood; expected one of: north")

    def ended():
        raise EOFError

    assert TerminalAnswerer(ended, shown.append).answer(question) is None
    assert TerminalAnswerer(lambda: "stop", shown.append).answer(question) is None


def test_answers_in_a_file(posterior, tmp_path):
    (question,) = ask(posterior, CITY, 1, kinds=["referent"])
    (tmp_path / "lines.txt").write_text("Barley House\n\nno idea\n")
    lines = FileAnswerer(tmp_path / "lines.txt")
    assert [lines.answer(question) for _ in range(3)] == ["Barley House", "no idea", None]
    (tmp_path / "a.json").write_text('{"do you mean by “bar”": "Ivy"}')
    assert FileAnswerer(tmp_path / "a.json").answer(question) == "Ivy"
    for name, text in (("empty.txt", " \n"), ("bad.json", "{]"), ("no.json", '{"a": 1}')):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError, match="Answers '"):
            FileAnswerer(tmp_path / name)


def test_answers_from_another_thread(posterior):
    questions: queue.Queue = queue.Queue()
    answers: queue.Queue = queue.Queue()
    asker = QueueAnswerer(questions, answers, timeout_s=5)
    seen = []

    def page():
        seen.append(questions.get())
        answers.put(seen[0]["answers"][0]["text"])

    thread = threading.Thread(target=page)
    thread.start()
    (question,) = ask(posterior, CITY, 1)
    assert asker.answer(question) == question.options[0]
    thread.join()
    assert set(seen[0]) == {"text", "about", "kind", "target", "bits", "answers"}
    with pytest.raises(InputError, match=r"No answer came within 0\.01 s"):
        QueueAnswerer(questions, answers, timeout_s=0.01).answer(question)


def test_the_simulated_person_errs_as_often_as_said(posterior):
    """The count lies within 5 standard deviations: a false alarm once in a million runs."""
    (question,) = ask(posterior, CITY, 1, kinds=["side"], person=AnswererModel.exact(0.3))
    cell = CITY.grid.cell_at(*PLACE["RedBike"])
    true = question.options[int(question.truth_by_cell()[:, cell[0], cell[1]].argmax())]
    right = sum(
        SimulatedAnswerer(PLACE, error=0.3, rng=np.random.default_rng(n)).answer(question) == true
        for n in range(500)
    )
    assert abs(right - 350) < 5 * np.sqrt(500 * 0.3 * 0.7)


def test_a_dialogue_ends_when_the_region_is_small(posterior):
    talk = converse(posterior, oracle(), small_m2=3000, person=AnswererModel.exact(0.05))
    assert talk.ended == "the 90 % regions are at most 3000 m2"
    assert talk.posterior.hpd("RedBike").sum() * 25 <= 3000
    assert len(talk.turns) >= 2
    assert talk.to_json()[0]["answer"] == talk.turns[0].answer
    stopped = converse(posterior, Scripted())
    assert (stopped.turns, stopped.ended) == ((), "the person stopped")
    failed = converse(posterior, Scripted(RuntimeError("gone")))
    assert failed.ended == "no answer: gone"
    with pytest.raises(InputError, match="An area of 0 m2 is no size"):
        converse(posterior, Scripted(), small_m2=0)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"answerer": 3}, "The answerer is a int; expected an object with a method answer"),
        ({"answerer": Scripted(), "cost": -1.0}, "cost of a dialogue is -1.0; expected >= 0"),
        ({"answerer": Scripted(), "most": -1}, "most of a dialogue is -1; expected >= 0"),
    ],
)
def test_a_dialogue_that_cannot_be(values, message):
    with pytest.raises(InputError) as caught:
        Dialogue(**values)
    assert str(caught.value).startswith(message)
