"""Questions worth asking: which there are, what they are expected to tell, and who answers them.

Names load on first use, because they bring torch with them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking.answerer_model import AnswererModel
    from sloop_ppl.bridge.asking.answerers import (
        Answerer,
        FileAnswerer,
        QueueAnswerer,
        SimulatedAnswerer,
        TerminalAnswerer,
    )
    from sloop_ppl.bridge.asking.before_search import Conversation, converse
    from sloop_ppl.bridge.asking.candidates import CandidateQuestions, ask
    from sloop_ppl.bridge.asking.kinds import QUESTION_KINDS, Proposal, list_question_kinds
    from sloop_ppl.bridge.asking.landmark_salience import salience
    from sloop_ppl.bridge.asking.question import Answer, Question, QuestionValue
    from sloop_ppl.bridge.asking.questioner import Dialogue, PosteriorQuestioner
    from sloop_ppl.bridge.asking.scene import Scene

__all__ = [
    "QUESTION_KINDS",
    "Answer",
    "Answerer",
    "AnswererModel",
    "CandidateQuestions",
    "Conversation",
    "Dialogue",
    "FileAnswerer",
    "PosteriorQuestioner",
    "Proposal",
    "Question",
    "QuestionValue",
    "QueueAnswerer",
    "Scene",
    "SimulatedAnswerer",
    "TerminalAnswerer",
    "ask",
    "converse",
    "list_question_kinds",
    "salience",
]

_HOMES = {
    "answerer_model": ("AnswererModel",),
    "answerers": (
        "Answerer",
        "FileAnswerer",
        "QueueAnswerer",
        "SimulatedAnswerer",
        "TerminalAnswerer",
    ),
    "before_search": ("Conversation", "converse"),
    "candidates": ("CandidateQuestions", "ask"),
    "kinds": ("QUESTION_KINDS", "Proposal", "list_question_kinds"),
    "question": ("Answer", "Question", "QuestionValue"),
    "questioner": ("Dialogue", "PosteriorQuestioner"),
    "landmark_salience": ("salience",),
    "scene": ("Scene",),
}
_find = load_later(__name__, _HOMES)


def __getattr__(name: str) -> object:
    return _find(name)


def __dir__() -> list[str]:
    return sorted(__all__)
