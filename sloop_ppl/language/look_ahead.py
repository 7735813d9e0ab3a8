"""Look ahead in a sentence: what follows decides whose relation a phrase is."""

from __future__ import annotations

from dataclasses import replace

from sloop_ppl.language.grounds import GroundReader
from sloop_ppl.language.phrases import RelationPhrase, read_relation

__all__ = ["leads_on", "named_later", "shared"]

_FARTHEST = 20
_JOINTS = ("and", "comma", "sub", "but", "skip", "or")


def named_later(reader: GroundReader, at: int) -> bool:
    """Whether what is only called "the car" here is named in "... is the red Honda"."""
    for k in range(at + 1, at + _FARTHEST):
        kind = reader.kind(k)
        if kind in ("stop", "end", "figure"):
            return False
        if kind == "be":
            figure = reader.past(k + 1, "det", "possessive")
            return reader.kind(figure) == "figure" and k > at + 1
    return False


def leads_on(reader: GroundReader, at: int, after: int) -> bool:
    """Whether a phrase begins a clause whose subject follows: "and behind X is the car"."""
    if reader.kind(at - 1) not in _JOINTS:
        return False
    end = after
    for _ in range(4):
        be = reader.past(end, "be", "see", "subject", "pronoun", "robot", "route")
        if be > end:
            subject = reader.past(be, "det", "skip", "possessive", "same")
            return reader.kind(subject) == "figure"
        subject = reader.past(end, "det", "skip", "possessive")
        if subject > end and reader.kind(subject) == "figure":
            return reader.kind(subject + 1) in ("stop", "end", "comma", "and", "sub")
        n_grounds = len(reader.grounds)
        got = read_relation(reader, reader.past(end, "and", "comma", "skip"))
        del reader.grounds[n_grounds:]
        if got is None or not got[0].grounds:
            return False
        end = got[1]
    return False


def shared(reader: GroundReader, phrase: RelationPhrase, after: int) -> RelationPhrase | None:
    """Return a phrase with the ground of the next: "close to, but not on, Grant Street"."""
    onward = reader.past(after, "comma", "and", "or", "but", "neg", "only", "skip", "det")
    between = {reader.kind(k) for k in range(after, onward)}
    if not between & {"and", "or", "but", "neg"}:
        return None
    n_grounds = len(reader.grounds)
    got = read_relation(reader, onward)
    del reader.grounds[n_grounds:]
    if got is None or not got[0].grounds or got[0].grounds[0].kind != "landmark":
        return None
    return replace(phrase, grounds=got[0].grounds, joint=got[0].joint)
