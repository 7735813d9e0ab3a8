"""The scores of how well descriptions were read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sloop_ppl.eval._calibration import Calibration

__all__ = ["Miss", "ParseScore"]

Entry = tuple[str, str, str]


@dataclass(frozen=True)
class Miss:
    """A description that was not read as its gold says, in class of relation, ground or polarity.

    Parameters
    ----------
    id, text
        The description, as it was given to the parser.
    missed, spurious
        (figure, relation, ground) that only the gold, or only the parser, has. "not" stands before
        the relation of what is denied, and the words for a ground that has no id in brackets.
    """

    id: str
    text: str
    missed: tuple[Entry, ...]
    spurious: tuple[Entry, ...]


@dataclass(frozen=True)
class ParseScore:
    """How well a parser read a set of descriptions.

    Parameters
    ----------
    n
        Number of descriptions.
    tuple_f1, class_f1, pair_f1
        Micro F1 in [0, 1] of (figure, relation, ground), of the same with the relation's class, and
        of (figure, ground).
    precision, recall
        Precision and recall of the tuples, in [0, 1].
    per_relation
        Relation -> ``n`` (in the gold), ``precision``, ``recall``, ``f1``.
    misses
        Descriptions that were not wholly read right.
    polarity_f1
        Micro F1 of (figure, class, ground, whether it is denied). A description is wholly right
        when all that is required is read in this sense, and nothing wrong.
    linking_recall
        Share of the grounds of the gold that were found among the places of a description, in
        whatever relation.
    wholly_right, false_positives
        Number of descriptions, and of entries that were read and are wrong.
    not_scored
        Number of lines without gold, which are left out.
    statuses
        Status of what is to be read -> ``n``, ``precision``, ``recall``, ``f1`` of (figure, class,
        ground, status); of what is not -> ``n`` and ``read``, how many were read all the same.
    phenomena
        Phenomenon -> ``n`` descriptions that have it, how many are ``wholly_right``, ``f1`` as in
        `polarity_f1`, ``false_positives``.
    classes
        Class of ground, and ``"all"`` -> ``n`` required entries and the share ``read_right``, as in
        `polarity_f1`; ``"all"`` also has ``wrong_among_read``, the share wrong of all that was
        read, optional entries too. Empty where the gold has no classes.
    confidence
        Whether the parser's confidence is a probability; None unless asked for.
    parts
        Kind of part, and ``"all"`` -> ``n`` required entries whose gold gives a part, and the share
        ``read_right`` of those that are right as in `polarity_f1` and were read with that part: its
        kind and number, and its bearing to the nearest compass point. Empty where the gold has no
        parts.
    """

    n: int
    tuple_f1: float
    class_f1: float
    pair_f1: float
    precision: float
    recall: float
    per_relation: dict[str, dict[str, float]] = field(default_factory=dict)
    misses: tuple[Miss, ...] = ()
    polarity_f1: float = 0.0
    linking_recall: float = 1.0
    wholly_right: int = 0
    false_positives: int = 0
    not_scored: int = 0
    statuses: dict[str, dict[str, float]] = field(default_factory=dict)
    phenomena: dict[str, dict[str, float]] = field(default_factory=dict)
    classes: dict[str, dict[str, float]] = field(default_factory=dict)
    confidence: Calibration | None = None
    parts: dict[str, dict[str, float]] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop eval parse --json`` prints."""
        payload: dict[str, Any] = {
            "n": self.n,
            "tuple_f1": self.tuple_f1,
            "class_f1": self.class_f1,
            "pair_f1": self.pair_f1,
            "precision": self.precision,
            "recall": self.recall,
            "per_relation": self.per_relation,
            "polarity_f1": self.polarity_f1,
            "linking_recall": self.linking_recall,
            "wholly_right": self.wholly_right,
            "false_positives": self.false_positives,
            "not_scored": self.not_scored,
            "statuses": self.statuses,
            "phenomena": self.phenomena,
        }
        if self.classes:
            payload["classes"] = self.classes
        if self.parts:
            payload["parts"] = self.parts
        if self.confidence is not None:
            payload["confidence"] = self.confidence.to_json()
        return payload
