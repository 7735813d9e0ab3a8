"""Who answers: a person at the terminal, a simulated one, a file, a queue."""

from __future__ import annotations

import queue
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from sloop_ppl._foreign import ForeignFault, is_file, parse_json, read_text
from sloop_ppl.bridge.asking.question import DONT_KNOW
from sloop_ppl.errors import InputError
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking.question import Question
    from sloop_ppl.inference import AnswerFactor

__all__ = ["Answerer", "FileAnswerer", "QueueAnswerer", "SimulatedAnswerer", "TerminalAnswerer"]


@runtime_checkable
class Answerer(Protocol):
    """Whoever answers questions."""

    def answer(self, question: Question) -> str | AnswerFactor | None:
        """Return the answer in words; None when there is none and none will come.

        One whose words are already read may return what they say, an `AnswerFactor`.
        """
        ...


class TerminalAnswerer:
    """A person at the terminal: questions go to stderr, answers come from stdin.

    Parameters
    ----------
    read
        Returns the next line without its end; raises EOFError when there is none.
    write
        Called with each line that the person is to see.
    """

    def __init__(
        self, read: Callable[[], str] | None = None, write: Callable[[str], None] | None = None
    ) -> None:
        self._read, self._write = read or _read_line, write or _write_line

    def answer(self, question: Question) -> str | None:
        """Return what the person types; None at the end of the input or for "stop"."""
        self._write(question.text)
        while True:
            try:
                text = self._read().strip()
            except EOFError:
                return None
            if text.casefold() in ("stop", "quit", "exit"):
                return None
            try:
                question.answer(text)
            except InputError as error:
                self._write(f"{error} ('stop' ends)")
                continue
            return text


def _read_line() -> str:
    line = sys.stdin.readline()
    if not line:
        raise EOFError
    return line.rstrip("\n")


def _write_line(line: str) -> None:
    sys.stderr.write(f"{line}\n> ")
    sys.stderr.flush()


class SimulatedAnswerer:
    """A person who knows where the targets are, and errs.

    Parameters
    ----------
    places
        True place of each target, metres.
    error
        How often an answer is not the true one, in [0, 1).
    dont_know
        How often the person does not know, in [0, 1).
    rng
        Where answers are drawn from, each from its own child stream: the same question gets the
        same answer.

    Notes
    -----
    What the place does not settle, such as which of two banks was meant, is drawn from what the
    posterior holds of it if the target is where it is.
    """

    def __init__(
        self,
        places: Mapping[str, tuple[float, float]],
        *,
        error: float = 0.1,
        dont_know: float = 0.0,
        rng: np.random.Generator,
    ) -> None:
        self._places, self._error, self._dont_know, self._rng = places, error, dont_know, rng

    def answer(self, question: Question) -> str | None:
        """Return a drawn answer; None about a target whose place is not known."""
        if question.target not in self._places:
            return None
        cell = question.posterior.city.grid.cell_at(*self._places[question.target])
        rng = child(self._rng, "answer", question.text)
        if rng.random() < self._dont_know:
            return DONT_KNOW
        truth = question.truth_by_cell()[:, cell[0], cell[1]]
        true = int(rng.choice(len(truth), p=truth / truth.sum()))
        if rng.random() < self._error:
            others = [k for k in range(len(truth)) if k != true]
            true = others[int(rng.integers(len(others)))]
        return question.options[true]


class FileAnswerer:
    """Answers in a file: one a line in the order of the questions, or JSON of question -> answer.

    Parameters
    ----------
    path
        The file. JSON is an object whose keys are questions, or parts of them.

    Raises
    ------
    InputError
        When it cannot be read or holds no answer.
    """

    def __init__(self, path: str | Path) -> None:
        text = read_text(path, "Answers")
        self._by_question: dict[str, str] = {}
        self._lines: list[str] = []
        if text.lstrip().startswith("{"):
            try:
                known = parse_json(text)
            except ForeignFault as error:
                raise InputError(f"Answers '{path}' are no JSON: {error}") from error
            if not isinstance(known, dict) or not all(isinstance(v, str) for v in known.values()):
                raise InputError(
                    f"Answers '{path}' are no answers; expected an object of question: answer"
                )
            self._by_question = {str(k).casefold(): v for k, v in known.items()}
        else:
            self._lines = [line.strip() for line in text.splitlines() if line.strip()]
        if not (self._by_question or self._lines):
            raise InputError(f"Answers '{path}' hold no answer; expected one a line, or JSON")

    def answer(self, question: Question) -> str | None:
        """Return the next line, or what the file has for the question; None when it has nothing."""
        if self._by_question:
            asked = question.text.casefold()
            return next((a for q, a in self._by_question.items() if q in asked), None)
        return self._lines.pop(0) if self._lines else None


class QueueAnswerer:
    """Answers from another thread, such as that of a page.

    Parameters
    ----------
    questions
        Each question is put here, as what `question_json` makes of it.
    answers
        Answers are taken from here; None says that no more will come.
    timeout_s
        How long an answer is waited for, seconds; for ever when None.

    Raises
    ------
    InputError
        From `answer`, when none comes in time.
    """

    def __init__(
        self,
        questions: queue.Queue[Any],
        answers: queue.Queue[str | None],
        timeout_s: float | None = None,
    ) -> None:
        self._questions, self._answers, self._timeout_s = questions, answers, timeout_s

    def answer(self, question: Question) -> str | None:
        """Return the next answer that is put into the queue."""
        self._questions.put(question_json(question))
        try:
            return self._answers.get(timeout=self._timeout_s)
        except queue.Empty:
            raise InputError(f"No answer came within {self._timeout_s:g} s") from None


def question_json(question: Question) -> dict[str, Any]:
    """Return a question as ``sloop ask --json`` prints it.

    Returns
    -------
    dict
        ``text``, ``about``, ``kind``, ``target``, ``bits`` and ``answers``, each with ``text`` and
        ``p``.
    """
    return {
        "text": question.text,
        "about": question.about,
        "kind": question.kind,
        "target": question.target,
        "bits": question.bits,
        "answers": [{"text": answer.text, "p": answer.p} for answer in question.answers],
    }


def answerer_of(
    name: str,
    places: Mapping[str, tuple[float, float]],
    *,
    error: float,
    rng: np.random.Generator,
) -> Answerer:
    """Return the answerer that ``--answers`` names: human, simulated, or a file.

    Parameters
    ----------
    name
        ``"human"``, ``"simulated"`` or a path.
    places
        True places, for a simulated one.
    error
        How often a simulated one errs.
    rng
        Where a simulated one draws from.

    Raises
    ------
    InputError
        When it is neither, and no file is there.
    """
    if name == "human":
        return TerminalAnswerer()
    if name == "simulated":
        return SimulatedAnswerer(places, error=error, rng=rng)
    if not is_file(name):
        raise InputError(
            f"Answers '{name}' are no file; expected human, simulated, or a file of answers"
        )
    return FileAnswerer(name)
