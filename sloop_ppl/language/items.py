"""The items that phrases are built of: a stretch of words with one role each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sloop_ppl.language.values import Distance

__all__ = ["Chunk", "Cue"]


@dataclass(frozen=True, slots=True)
class Cue:
    """A surface form that needs a ground.

    Parameters
    ----------
    relation
        Its canonical relation.
    negated
        Whether the form itself denies.
    distance
        A distance that stands elsewhere: of "30 m down A from B" to B.
    """

    relation: str
    negated: bool = False
    distance: Distance | None = None


@dataclass(frozen=True, slots=True)
class Chunk:
    """A stretch of words with one role.

    Parameters
    ----------
    kind
        ``landmark``, ``figure``, ``cue``, ``dir``, ``distance``, ``place``, ``stop``, ...
    first, last
        Half-open range of words.
    value
        What it stands for.
    """

    kind: str
    first: int
    last: int
    value: Any = None
