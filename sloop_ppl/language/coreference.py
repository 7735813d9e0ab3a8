"""Remember which objects were spoken of, so that "it" and "the other car" can be understood."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice

from sloop_ppl.language.figures import FigureFinder, FigureMention
from sloop_ppl.language.values import TargetObject

__all__ = ["Figures"]


@dataclass
class Figures:
    """The objects spoken of so far.

    Parameters
    ----------
    finder
        The objects that can be spoken of.
    order
        Ids in the order they were first spoken of -> when they were last spoken of.
    """

    finder: FigureFinder
    order: dict[str, int] = field(default_factory=dict)
    inferred: dict[str, TargetObject] = field(default_factory=dict)
    _last: tuple[str, ...] = ()
    _turn: int = 0

    @property
    def open_ended(self) -> bool:
        """Whether objects that no one declared may be inferred."""
        return self.finder.declared is None

    def resolve(self, mention: FigureMention) -> tuple[str, ...]:
        """Return the ids of the objects that a mention stands for; empty when it is unknown."""
        ids = mention.candidates
        if mention.plural:
            return self._plural(ids)
        if mention.other:
            rest = tuple(i for i in ids if i not in self._last) or ids
            mentioned = tuple(i for i in rest if i in self.order)
            return (mentioned or rest)[:1]
        if len(ids) < 2:
            return ids
        recent = self._recent(ids)
        if recent:
            last = tuple(i for i in self._last if i in ids)
            return (last or recent)[:1]
        return ids[:1] if not self.open_ended else ()

    def _plural(self, ids: tuple[str, ...]) -> tuple[str, ...]:
        mentioned = tuple(i for i in ids if i in self.order)
        return mentioned if len(mentioned) > 1 else ids

    def known(self, ids: tuple[str, ...]) -> tuple[str, ...]:
        """Return the first of the ids, the one last spoken of if one was."""
        return self._recent(ids)[:1] or ids[:1]

    def _recent(self, ids: tuple[str, ...]) -> tuple[str, ...]:
        """Return those of the ids that were spoken of, the latest first."""
        mentioned = [i for i in ids if i in self.order]
        return tuple(sorted(mentioned, key=lambda i: -self.order[i]))

    def spoke_of(self, ids: tuple[str, ...]) -> None:
        """Remember that these objects were the subject."""
        for one in ids:
            self._turn += 1
            self.order[one] = self._turn
        if ids:
            self._last = ids

    def referred_to(self, ids: tuple[str, ...]) -> None:
        """Remember that these objects were named, though not as the subject."""
        for one in ids:
            self.order.setdefault(one, 0)

    def infer(self, target: TargetObject) -> None:
        """Add an object that was not declared."""
        self.inferred.setdefault(target.id, target)

    def last(self) -> tuple[str, ...]:
        """Return the object spoken of last; the only one declared where none was."""
        if not self._last and self.finder.declared is not None and len(self.finder.known) == 1:
            return (self.finder.known[0].id,)
        return self._last[-1:]

    def all(self) -> tuple[str, ...]:
        """Return the objects that "they" stands for."""
        return (
            self._last
            if len(self._last) > 1
            else tuple(reversed([*islice(reversed(self.order), 3)]))
        )

    def targets(self) -> tuple[TargetObject, ...]:
        """Return the objects spoken of, in order."""
        known = {t.id: t for t in self.finder.known} | self.inferred
        return tuple(known.get(i, TargetObject(i)) for i in self.order)
