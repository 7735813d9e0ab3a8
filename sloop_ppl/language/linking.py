"""Link words of text to landmarks by aligning them with names, the rare words weighing most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.name_index import Hit, Name, NameIndex, canonical
from sloop_ppl.language.words import Word

__all__ = ["LandmarkMention", "link_landmarks"]

_GAP_COST = 0.2
_ACCEPT = 0.5
_ACCEPT_RARE = 0.2
_ACCEPT_HEADED = 0.3
_ALONE = 0.8
_SOFT_MARKS = frozenset("-.'’")


@dataclass(frozen=True, slots=True)
class LandmarkMention:
    """Words that name a landmark.

    Parameters
    ----------
    first, last
        Half-open range of words.
    candidates
        Positions of landmarks in the map, best first; several when the words do not tell them
        apart.
    score
        Share of the name's weight that was found, in (0, 1].
    rivals
        Positions of landmarks that fit the words less well.
    """

    first: int
    last: int
    candidates: tuple[int, ...]
    score: float
    rivals: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class _Fit:
    """One alignment of a name with words."""

    first: int
    last: int
    landmark: int
    matched: float
    coverage: float


def link_landmarks(words: Sequence[Word], index: NameIndex) -> list[LandmarkMention]:
    """Return the landmarks that `words` name, in order, not overlapping.

    Digits and compass words are never matched approximately. Time is linear in the words.

    Parameters
    ----------
    words
        The text.
    index
        Names of the map.
    """
    spots = _spots(words, index)
    cased = any(w.text[:1].isupper() for w in words[1:])
    near: dict[int, list[tuple[int, int, Hit]]] = {}
    for spot in spots:
        near.setdefault(spot[2].name, []).append(spot)
    fits: dict[tuple[int, int, int], _Fit] = {}
    for n, found in near.items():
        name = index.names[n]
        if name.landmark in index.junction_names:
            continue
        _align(words, name, found, fits)
    if cased:
        fits = {key: fit for key, fit in fits.items() if not _common_noun(words, fit)}
    return _choose(sorted(fits.values(), key=_preference), len(words))


def _spots(words: Sequence[Word], index: NameIndex) -> list[tuple[int, int, Hit]]:
    """Return (first word, last word, hit) for all words, two that were torn apart included."""
    spots: list[tuple[int, int, Hit]] = []
    for i, word in enumerate(words):
        if word.kind == "mark" and word.low not in "&+":
            continue
        if word.low in lexicon().compass and i + 1 < len(words) and words[i + 1].low == "of":
            continue  # "south of Sokos" is a direction, no "S" of a name
        spots += [(i, i + 1, hit) for hit in index.hits(word.low)]
        j = i + 2 if i + 1 < len(words) and words[i + 1].low == "-" else i + 1
        if j < len(words) and words[j].kind == "word" and word.kind != "mark":
            joined = index.vocabulary.get(word.low + words[j].low)
            if joined:
                spots += [(i, j + 1, hit) for hit in joined]
    return spots


def _align(
    words: Sequence[Word],
    name: Name,
    spots: list[tuple[int, int, Hit]],
    fits: dict[tuple[int, int, int], _Fit],
) -> None:
    """Add the best alignments of one name, cutting its spots where the words are far apart."""
    cluster: list[tuple[int, int, Hit]] = []
    for spot in spots:
        if cluster and (
            spot[0] > cluster[-1][1] + 2
            or len(cluster) > 2 * len(name.tokens) + 2
            or not _bridged(words, cluster[-1][1], spot[0])
        ):
            _align_cluster(words, name, cluster, fits)
            cluster = []
        cluster.append(spot)
    if cluster:
        _align_cluster(words, name, cluster, fits)


def _bridged(words: Sequence[Word], last: int, first: int) -> bool:
    """Whether the words between two spots may be part of a name."""
    return all(_gap(words[k]) is not None for k in range(last, first))


def _gap(word: Word) -> float | None:
    """Return the cost of leaving a word out of an alignment, None when it may not be left out."""
    if word.kind == "mark":
        return 0.0 if word.low in _SOFT_MARKS else None
    if word.kind == "number":
        return None
    if word.low in ("the", "of", "'s"):
        return 0.0
    known = lexicon()
    if word.low in known.closed and canonical(word.low) not in known.generic:
        return None
    return _GAP_COST


def _align_cluster(
    words: Sequence[Word],
    name: Name,
    cluster: list[tuple[int, int, Hit]],
    fits: dict[tuple[int, int, int], _Fit],
) -> None:
    """Align a name with neighbouring spots; may give several fits when the name is said twice."""
    best: list[tuple[float, int]] = []
    for k, (first, _, hit) in enumerate(cluster):
        gain = sum(name.weights[hit.first : hit.last]) * hit.similarity
        top, back = gain, -1
        for b in range(k):
            _, blast, bhit = cluster[b]
            if blast <= first and bhit.last <= hit.first:
                cost = sum(_gap(words[w]) or 0.0 for w in range(blast, first))
                if best[b][0] + gain - cost > top:
                    top, back = best[b][0] + gain - cost, b
        best.append((top, back))
    used: set[int] = set()
    for k in sorted(range(len(cluster)), key=lambda i: -best[i][0]):
        path = []
        at = k
        while at >= 0 and at not in used:
            path.append(at)
            at = best[at][1]
        if at >= 0 or not path:
            continue
        used.update(path)
        chosen = [cluster[i] for i in reversed(path)]
        fit = _judge(words, name, chosen, best[k][0])
        if fit is not None:
            key = fit.first, fit.last, fit.landmark
            if key not in fits or fits[key].coverage < fit.coverage:
                fits[key] = fit


def _judge(
    words: Sequence[Word], name: Name, chosen: list[tuple[int, int, Hit]], matched: float
) -> _Fit | None:
    """Return the fit when enough of the name was said, else None."""
    first, last = chosen[0][0], chosen[-1][1]
    coverage = matched / name.total
    informative = [
        (hit, name.tokens[p])
        for _, _, hit in chosen
        for p in range(hit.first, hit.last)
        if name.informative[p]
    ]
    known = lexicon()
    if not informative:
        whole = sum(h.last - h.first for _, _, h in chosen) == len(name.tokens)
        if not (whole and (len(name.tokens) > 1 or not _is_kind_word(name.tokens[0]))):
            return None
    elif coverage < _ACCEPT:
        headed = (
            len(chosen) > 1
            and chosen[-1][2].last == len(name.tokens)
            and coverage >= _ACCEPT_HEADED
            and any(hit.similarity == 1.0 for hit, _ in informative)
        )
        rare = headed or any(
            hit.similarity >= (1.0 if len(t) < 5 else _ALONE)
            and t not in known.common
            and t not in known.closed
            for hit, t in informative
        )
        if not rare or coverage < _ACCEPT_RARE:
            return None
    elif len(chosen) == 1:
        hit, token = informative[0]
        if hit.similarity < _ALONE or (hit.similarity < 1.0 and len(token) < 5):
            return None
        if len(name.tokens) > 1 and (token in known.common or token in known.closed):
            return None
    if _compass_conflict(words, name, chosen):
        return None
    return _Fit(first, last, name.landmark, matched, coverage)


def _is_kind_word(token: str) -> bool:
    return any(token == canonical(w) for kind in lexicon().place_kinds for w in kind.words)


def _compass_conflict(
    words: Sequence[Word], name: Name, chosen: list[tuple[int, int, Hit]]
) -> bool:
    """Whether the text says another compass word than the name does ("East" for "West 6th")."""
    compass = lexicon().compass
    compass_words = [t for t in name.tokens if t in compass]
    first = chosen[0][0]
    if not compass_words or first == 0 or name.tokens[chosen[0][2].first] in compass:
        return False
    before = words[first - 1]
    if before.low == "." and first > 1:
        before = words[first - 2]
    return canonical(before.low) in compass and canonical(before.low) not in compass_words


def _common_noun(words: Sequence[Word], fit: _Fit) -> bool:
    """Whether a small part of a name is written small in a text that has capitals."""
    return fit.coverage < _ACCEPT and fit.last == fit.first + 1 and words[fit.first].text.islower()


def _preference(fit: _Fit) -> tuple[float, float, int, int]:
    return -round(fit.matched, 3), -round(fit.coverage, 3), fit.first, fit.landmark


def _choose(fits: list[_Fit], n_words: int) -> list[LandmarkMention]:
    """Keep the fits that explain most, none overlapping; ties become candidates."""
    taken: list[int] = [-1] * n_words
    chosen: list[tuple[_Fit, list[int], list[int]]] = []
    for fit in fits:
        owners = {taken[w] for w in range(fit.first, fit.last)} - {-1}
        if not owners:
            for w in range(fit.first, fit.last):
                taken[w] = len(chosen)
            chosen.append((fit, [fit.landmark], []))
            continue
        if len(owners) == 1:
            best, candidates, rivals = chosen[owners.pop()]
            if fit.landmark in candidates or fit.landmark in rivals:
                continue
            same = (fit.first, fit.last) == (best.first, best.last)
            tie = same and best.coverage - fit.coverage < 0.02
            (candidates if tie else rivals).append(fit.landmark)
    mentions = [
        LandmarkMention(f.first, f.last, tuple(c), min(1.0, f.coverage), tuple(r))
        for f, c, r in chosen
    ]
    return sorted(mentions, key=lambda m: m.first)
