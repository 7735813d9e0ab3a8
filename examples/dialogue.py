"""Search for a bike by one of two bars, asking twice.

The sentence names "the bar", and there are two; the search starts beside the wrong one. The program
believes in both, asks, finds that it read the wrong one, and flies to the other. The picture shows
the belief before and after each answer, and the search with and without asking.

    python examples/dialogue.py --out dialogue.png
"""

from __future__ import annotations

import argparse
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import sloop_ppl as sloop
from sloop_ppl.bridge.asking import Dialogue, SimulatedAnswerer
from sloop_ppl.plots import plot_belief, plot_search, save_figure

TEXT = "The red bike is by the bar."
TARGET = "RedBike"
PLACE = {TARGET: (2.5, 32.5)}
START = (-90.0, 40.0)


@dataclass(frozen=True)
class Result:
    """What asking changed."""

    questions: tuple[str, ...]
    answers: tuple[str, ...]
    bar: tuple[dict[str | None, float], ...]
    asking: float
    silent: float


class Remembering:
    """An answerer whose questions are kept, to draw what was believed at each."""

    def __init__(self, answerer: SimulatedAnswerer) -> None:
        self.answerer, self.questions = answerer, []

    def answer(self, question: sloop.bridge.Question) -> str | None:
        """Answer and keep the question."""
        self.questions.append(question)
        return self.answerer.answer(question)


def main(out: Path, smoke: bool = False) -> Result:
    """Search twice, with questions and without, and draw it."""
    city = sloop.load_map("cleveland")
    before = sloop.infer(TEXT, city)
    person = Remembering(SimulatedAnswerer(PLACE, error=0.0, rng=np.random.default_rng(1)))
    episodes = [
        sloop.search(
            before, city, PLACE, start=START, rng=np.random.default_rng(0),
            dialogue=dialogue,
        )
        for dialogue in (Dialogue(person, most=2, cost=10.0), None)
    ]  # fmt: skip
    asking, silent = episodes
    states = [question.posterior for question in person.questions] + [asking.posterior]
    titles = ["Before"] + [f"{q.text} — {q.answer}" for q in asking.questions]
    figure = Figure(figsize=(18, 13), layout="constrained")
    axes = figure.subplots(2, 3).ravel()
    for ax, title, state in zip(
        axes, titles, [*states[:-1], believed(before, asking)], strict=False
    ):
        plot_belief(
            state, TARGET, ax=ax, truth=PLACE[TARGET], title=textwrap.fill(title, 60),
            legend=False, colour_bar=False,
        )  # fmt: skip
    for ax, episode in zip(axes[3:], episodes, strict=False):
        plot_search(episode, city, ax=ax)
    axes[5].set_axis_off()
    figure.suptitle(f"“{TEXT}”")
    save_figure(figure, out, dpi=40 if smoke else 70)
    result = Result(
        tuple(q.text for q in asking.questions),
        tuple(str(q.answer) for q in asking.questions),
        tuple(bar(state) for state in states),
        asking.discounted_return,
        silent.discounted_return,
    )
    print(f"“{TEXT}”")
    for number, question in enumerate(asking.questions):
        print(f"the bar may be {shares(result.bar[number])}")
        print(f"after {question.step} steps: {question.text} {question.answer}")
    print(f"the bar was {shares(result.bar[-1])}")
    print(f"{result.asking:.0f} asking, {result.silent:.0f} without")
    return result


def believed(before: sloop.Posterior, episode: sloop.bridge.PosteriorEpisode) -> sloop.Posterior:
    """Return what was believed after the answers, before anything was seen."""
    after = episode.posterior
    for answer in () if after is None else after.answers:
        before = before.update(answer)
    return before


def bar(posterior: sloop.Posterior) -> dict[str | None, float]:
    """Return which bar is meant."""
    (mention,) = posterior.grounds(TARGET)
    return {c.ground: c.p for c in mention.candidates}


def shares(places: dict[str | None, float]) -> str:
    """Return probabilities in words."""
    return ", ".join(f"{place or 'none of these'} {p:.2f}" for place, p in places.items())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("dialogue.png"))
    parser.add_argument("--smoke", action="store_true")
    options = parser.parse_args()
    main(options.out, options.smoke)
