"""The kinds of questions by name; one of your own is a function and one line.

Shape legend: A options; V values of the latent that a question is about, S cells where that is the
target's cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.registry import Registry

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking.scene import Scene

__all__ = ["QUESTION_KINDS", "About", "Proposal", "QuestionKind", "list_question_kinds"]

Table = NDArray[np.float64]

About: TypeAlias = Literal["cell", "referent", "frame", "reading", "component"]
"""What a question settles first."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A question that may be worth asking.

    Parameters
    ----------
    text
        The question.
    options
        The answers that are offered, at least two.
    table
        What is true: called with a `Scene`, it returns the probability of each option of one who
        does not err, shape (A, V), columns summing to one.
    landmarks
        Ids of the landmarks it names.
    about
        What it settles.
    latent
        Name of the latent in the joint posterior; the target's cell when None.
    others
        Answers that are not offered but understood -> the same as `table` returns for one, shape
        (V,): "neither" of "nearer to A or to B?".
    described_in
        Text of the description whose latent it is; empty for a cell.
    """

    text: str
    options: tuple[str, ...]
    table: Callable[[Scene], Table]
    landmarks: tuple[str, ...] = ()
    about: About = "cell"
    latent: str | None = None
    others: Mapping[str, Callable[[Scene], Table]] = field(default_factory=dict)
    described_in: str = ""


QuestionKind: TypeAlias = "Callable[[Scene], Iterable[Proposal]]"
"""Called with the scene of a target, it returns the questions of its kind."""

QUESTION_KINDS: Registry[QuestionKind] = Registry("kind of question")
"""Kinds of questions by name; add your own with ``QUESTION_KINDS.add(name, function)``."""

for _name, _module, _function in (
    ("side", "_cell_kinds", "sides"),
    ("nearer", "_cell_kinds", "nearer"),
    ("inside", "_cell_kinds", "inside"),
    ("street", "_cell_kinds", "streets"),
    ("distance", "_cell_kinds", "distances"),
    ("referent", "_meaning_kinds", "referents"),
    ("reading", "_meaning_kinds", "readings"),
    ("frame", "_meaning_kinds", "frames"),
):
    QUESTION_KINDS.add_later(_name, f"sloop_ppl.bridge.asking.{_module}", _function)


def list_question_kinds() -> list[str]:
    """Return the names of the kinds of questions.

    Examples
    --------
    >>> list_question_kinds()[:3]
    ['side', 'nearer', 'inside']
    """
    return list(QUESTION_KINDS)
