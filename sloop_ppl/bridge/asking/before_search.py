"""A dialogue without a search: ask until the target is known well enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sloop_ppl.bridge.asking.answerer_model import AnswererModel
from sloop_ppl.bridge.asking.answerers import Answerer
from sloop_ppl.bridge.asking.candidates import ask
from sloop_ppl.errors import BeliefCollapse, InputError, on_one_line
from sloop_ppl.inference import AnswerFactor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sloop_ppl.bridge.asking.question import Question
    from sloop_ppl.inference import Posterior

__all__ = ["Conversation", "Turn", "converse", "figure_of_conversation"]

SMALL_M2 = 1000.0
"""Area of the 90 % region at which nothing more is asked: 40 cells of 5 m."""


@dataclass(frozen=True)
class Turn:
    """One question and what came of it.

    Parameters
    ----------
    question
        The question.
    answer
        The answer; None when there was none.
    posterior
        What is believed after it.
    note
        What is to be said about it; may be empty.
    """

    question: Question
    answer: str | None
    posterior: Posterior
    note: str = ""


@dataclass(frozen=True)
class Conversation:
    """A dialogue.

    Parameters
    ----------
    before
        What was believed at first.
    turns
        The questions and answers.
    ended
        Why no more was asked.
    """

    before: Posterior
    turns: tuple[Turn, ...]
    ended: str

    @property
    def posterior(self) -> Posterior:
        """What is believed in the end."""
        return self.turns[-1].posterior if self.turns else self.before

    def to_json(self) -> list[dict[str, Any]]:
        """Return the questions and answers as JSON values."""
        return [
            {
                "text": turn.question.text,
                "about": turn.question.about,
                "answer": turn.answer,
                "bits": turn.question.bits,
                "hpd90_cells": int(turn.posterior.hpd(turn.question.target).sum()),
                **({"note": turn.note} if turn.note else {}),
            }
            for turn in self.turns
        ]


def converse(
    posterior: Posterior,
    answerer: Answerer,
    *,
    small_m2: float = SMALL_M2,
    most: int = 10,
    person: AnswererModel | None = None,
    notify: Callable[[str], None] | None = None,
) -> Conversation:
    """Ask until the 90 % region of every target is small enough, or the person stops.

    Parameters
    ----------
    posterior
        What is believed.
    answerer
        Who answers.
    small_m2
        Area at which a region is small enough, square metres, > 0.
    most
        How many questions at most.
    person
        How the person is believed to answer.
    notify
        Called with what changes.

    Raises
    ------
    InputError
        When the area is not positive.
    """
    if not small_m2 > 0:
        raise InputError(f"An area of {small_m2} m2 is no size; expected a positive number")
    tell = notify or (lambda _line: None)
    turns: list[Turn] = []
    now, ended = posterior, f"asked {most} questions"
    while len(turns) < most:
        wide = [t for t in now.targets if _region_m2(now, t) > small_m2]
        if not wide:
            ended = f"the 90 % regions are at most {small_m2:g} m2"
            break
        asked = [turn.question.text for turn in turns]
        found = [q for t in wide for q in ask(now, now.city, 1, target=t, person=person,
                                              without=asked)]  # fmt: skip
        if not found:
            ended = "nothing is worth asking"
            break
        question = max(found, key=lambda q: q.bits)
        try:
            text = answerer.answer(question)
        except Exception as error:  # whoever answers may be any program
            ended = f"no answer: {on_one_line(str(error) or type(error).__name__, 120)}"
            break
        if text is None:
            ended = "the person stopped"
            break
        turn = _turn(now, question, text)
        turns.append(turn)
        tell(_change(now, turn))
        now = turn.posterior
    return Conversation(posterior, tuple(turns), ended)


def _turn(before: Posterior, question: Question, text: str | AnswerFactor) -> Turn:
    words = text.answer if isinstance(text, AnswerFactor) else text
    try:
        factor = question.answer(text) if isinstance(text, str) else text
        after = before.update(factor)
    except BeliefCollapse:
        return Turn(question, words, before, "not believed: it excludes all else")
    except InputError:
        return Turn(question, words, before, "not understood")
    doubted = [c for c in after.checked_answers() if c.factor.informs and c.p < 0.5]
    note = "; ".join(f"doubted: “{c.factor.answer}”, right with {c.p:.2f}" for c in doubted)
    return Turn(question, words, after, note)


def _region_m2(posterior: Posterior, target: str) -> float:
    return float(posterior.hpd(target).sum()) * posterior.city.grid.cell_m**2


def _change(before: Posterior, turn: Turn) -> str:
    """Return a line on how the region of the target has changed."""
    target = turn.question.target
    old, new = (_region_m2(p, target) for p in (before, turn.posterior))
    note = f" ({turn.note})" if turn.note else ""
    return f"{target}: 90 % within {new:,.0f} m2 (was {old:,.0f} m2){note}"


def figure_of_conversation(conversation: Conversation, target: str | None = None) -> Figure:
    """Draw what is believed of a target before the first question and after each answer.

    Parameters
    ----------
    conversation
        The dialogue.
    target
        Id of the target; that of the first question when None.
    """
    import textwrap

    from matplotlib.figure import Figure

    from sloop_ppl.plots import plot_belief

    chosen = target or next(
        (turn.question.target for turn in conversation.turns), conversation.before.targets[0]
    )
    states = [("Before", conversation.before)]
    states += [
        (f"{turn.question.text} — {turn.answer}", turn.posterior) for turn in conversation.turns
    ]
    columns = min(len(states), 3)
    rows = -(-len(states) // columns)
    figure = Figure(figsize=(5.2 * columns, 5.6 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, (title, posterior) in zip(axes, states, strict=False):
        plot_belief(
            posterior, chosen, ax=ax, title=textwrap.fill(title, 46), legend=False, labels=True
        )
    for ax in axes[len(states) :]:
        ax.set_axis_off()
    return figure
