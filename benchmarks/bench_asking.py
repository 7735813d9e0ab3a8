"""Time the choice of questions, and score beliefs after each of three questions.

Run: python benchmarks/bench_asking.py [FILE.jsonl ... --maps DIR] [--parsed] [--answerer a|b]
         [--quick]

CPU times: 200 candidate questions on a map of 41 x 41 cells (to be under 50 ms) and on one of
401 x 401 (under 1 s, compared on at most 2,000 cells, the best exactly), first and again; a
decision of `fast` that weighs questions (under 30 ms). Scores: mean log score of the true cell (1 %
uniform of the area mixed in), before and after one, two and three questions, each the one with the
largest expected information; the answerer errs in 10 %. Without files: the bundled examples.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import sloop_ppl as sloop
from sloop_ppl.bridge.asking import CandidateQuestions, ask
from sloop_ppl.errors import SloopError
from sloop_ppl.eval import bundled_examples, read_descriptions
from sloop_ppl.eval._answerers import AskingSettings, OracleAnswerer, PersonAnswerer
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval.quality import read_annotated
from sloop_ppl.inference import infer_description
from sloop_ppl.models import preset
from sloop_ppl.planning import GridBelief, QuestionTable, SearchConfig, SearchSpace
from sloop_ppl.planning._ask_value import ReturnEstimator
from sloop_ppl.rng import child

TEXT = "the red honda is behind Velvet Dog"
CELL_KINDS = ("side", "nearer", "inside", "street", "distance")


def times(rounds):
    """Print how long choosing takes."""
    for cell_m in (5.0, 0.5):
        city = sloop.load_map("cleveland", cell_m=cell_m)
        posterior = sloop.infer(TEXT, city)
        posterior.belief("RedHonda")
        took = []
        for _ in range(rounds if cell_m > 1 else 3):
            begun = time.process_time()
            candidates = CandidateQuestions(
                posterior, "RedHonda", kinds=CELL_KINDS, most_landmarks=60
            )
            candidates.question(candidates.best(1)[0])
            took.append(time.process_time() - begun)
        each = 1e3 * np.array(took) * 200 / len(candidates)
        rows, cols = city.grid.shape
        first, later = each[0], np.median(each[1:])
        print(
            f"{len(candidates)} candidates at {rows} x {cols}, CPU: first {1e3 * took[0]:.0f} ms, "
            f"then {1e3 * np.median(took[1:]):.0f} ms; of 200: {first:.0f}, {later:.0f}"
        )
    city = sloop.load_map("cleveland")
    posterior = sloop.infer(TEXT, city)
    candidates = CandidateQuestions(posterior, "RedHonda")
    space = SearchSpace.of_city(city, ("RedHonda",), SearchConfig())
    estimator, took, made = ReturnEstimator(space), [], {}
    belief = posterior.belief("RedHonda")
    for n in range(rounds):
        robot = space.robot(space.encode(5 + n % 30, 5 + 3 * n % 30, n % 8))
        at = GridBelief(space, {"RedHonda": belief}, robot, rng=np.random.default_rng(0))
        begun = time.process_time()
        offered = candidates.best(4, belief)
        for k in offered:  # a question is made once in a search
            if k not in made:
                question = candidates.question(k)
                made[k] = QuestionTable(question.text, "RedHonda", question.p_answer(), 10.0)
        tables = [made[k] for k in offered]
        estimator.best(at, tables)
        took.append(time.process_time() - begun)
    print(f"a decision of fast that weighs questions, CPU: {1e3 * np.median(took[1:]):.0f} ms")


def scores(files, maps, parsed, kind, most, every):
    """Print the mean log score before and after questions."""
    find = map_finder(maps)
    lines = read_descriptions(files, find) if files else bundled_examples()
    model, settings = preset("bayes"), AskingSettings(answerer=kind)
    rows = []
    for line in lines[::every]:
        city, said = read_annotated(line, find(line.map), "parsed" if parsed else "gold")
        area = line.search_area(city.grid)
        inside = np.ones(city.grid.shape, bool) if area is None else area.cells
        try:
            posterior = infer_description(said, city, model, area=area)[0]
        except SloopError:
            continue
        for target, place in line.places(city.grid).items():
            if target not in posterior.targets:
                continue
            rng = child(np.random.default_rng(0), "answers", line.id, target)
            answerer = OracleAnswerer(line, target, place.cell, error=0.1, guess=0.0, rng=rng)
            if kind == "b":
                at = (place.x_m, place.y_m)
                answerer = PersonAnswerer(line, target, at, city, error=0.1, rng=rng)
            now, asked = posterior, []
            row = [score(now.belief(target), place.cell, inside)]
            for _ in range(most):
                found = ask(
                    now, city, 1, target=target, kinds=CELL_KINDS, person=settings.person,
                    without=asked,
                )  # fmt: skip
                if found:
                    asked.append(found[0].text)
                    now = now.update(found[0].answer(answerer.answer(found[0])))
                row.append(score(now.belief(target), place.cell, inside))
            rows.append(row)
    table = np.array(rows)
    steps = np.diff(table, axis=1)
    print(f"{len(table)} targets, answerer {kind}: log score {table.mean(0).round(2).tolist()}")
    errors = (steps.std(0) / len(table) ** 0.5).round(2).tolist()
    print(f"gain of each question {steps.mean(0).round(2).tolist()}, SE {errors}")


def score(belief, cell, inside):
    """Return the log score with 1 % uniform of the area mixed in."""
    return float(np.log(0.99 * belief[cell] + 0.01 / inside.sum()))


def main():
    """Print times and scores."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--maps", type=Path)
    parser.add_argument("--parsed", action="store_true")
    parser.add_argument("--answerer", default="a", choices=("a", "b"))
    parser.add_argument("--questions", type=int, default=3)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--no-times", action="store_true")
    parser.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    options = parser.parse_args()
    if options.quick:
        options.every, options.questions = 16, 1
    if not options.no_times:
        times(3 if options.quick else 20)
    scores(
        options.files, options.maps, options.parsed, options.answerer, options.questions,
        options.every,
    )  # fmt: skip


if __name__ == "__main__":
    main()
