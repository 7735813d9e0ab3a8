"""Link words of text to landmarks by aligning them with names, the rare words weighing most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sloop_ppl.language.addresses import link_addresses
from sloop_ppl.language.kinds import is_kind_noun
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.mentions import LandmarkMention
from sloop_ppl.language.name_index import Hit, Name, NameIndex, canonical
from sloop_ppl.language.ordinary import is_common, is_ordinary
from sloop_ppl.language.referents import referents
from sloop_ppl.language.word_roles import ALWAYS_CAPITAL, BARE, PERSONS, Roles, find_roles
from sloop_ppl.language.words import Word

__all__ = ["LandmarkMention", "link_landmarks"]

_GAP_COST = 0.2
_ACCEPT = 0.5
_ACCEPT_RARE = 0.2
_ACCEPT_HEADED = 0.3
_ANSWER = 8  # words and marks of an answer at most
_ALONE = 0.8
_TIE = 0.02
_SAME_WORDS = 0.03
_SOFT_MARKS = frozenset("-.'’")


@dataclass(frozen=True, slots=True)
class _Fit:
    """One alignment of a name with words."""

    first: int
    last: int
    landmark: int
    matched: float
    coverage: float
    kernel: tuple[int, ...] = ()  # the words that tell something


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
    roles = find_roles(words)
    near: dict[int, list[tuple[int, int, Hit]]] = {}
    for spot in _spots(words, index):
        near.setdefault(spot[2].name, []).append(spot)
    fits: dict[tuple[int, int, int], _Fit] = {}
    for n, found in near.items():
        name = index.names[n]
        if name.landmark in index.junction_names:
            continue
        _align(words, name, found, fits, roles)
    chosen = _choose(sorted(fits.values(), key=_preference), len(words))
    return link_addresses(words, chosen, roles, index)


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
        small = {word.low, words[j].low} <= lexicon().closed if j < len(words) else True
        if not small and words[j].kind == "word" and word.kind != "mark":
            joined = index.vocabulary.get(word.low + words[j].low)
            if joined:
                spots += [(i, j + 1, hit) for hit in joined]
    return spots


def _align(
    words: Sequence[Word],
    name: Name,
    spots: list[tuple[int, int, Hit]],
    fits: dict[tuple[int, int, int], _Fit],
    roles: Roles,
) -> None:
    """Add the best alignments of one name, cutting its spots where the words are far apart."""
    cluster: list[tuple[int, int, Hit]] = []
    for spot in spots:
        if cluster and (
            spot[0] > cluster[-1][1] + 2
            or len(cluster) > 2 * len(name.tokens) + 2
            or not _bridged(words, cluster[-1][1], spot[0])
        ):
            _align_cluster(words, name, cluster, fits, roles)
            cluster = []
        cluster.append(spot)
    if cluster:
        _align_cluster(words, name, cluster, fits, roles)


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
    roles: Roles,
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
        fit = _judge(words, name, chosen, best[k][0], roles)
        if fit is not None:
            key = fit.first, fit.last, fit.landmark
            if key not in fits or fits[key].coverage < fit.coverage:
                fits[key] = fit


def _judge(
    words: Sequence[Word],
    name: Name,
    chosen: list[tuple[int, int, Hit]],
    matched: float,
    roles: Roles,
) -> _Fit | None:
    """Return the fit when enough of the name was said, in a role that names have, else None."""
    first, last = chosen[0][0], chosen[-1][1]
    coverage = matched / name.total
    distinctive = [
        spot
        for spot in chosen
        if any(
            name.informative[p] and not name.tokens[p].isdigit()
            for p in range(spot[2].first, spot[2].last)
        )
    ]
    measured = any(roles.measure[i] for i in range(first, last))
    if measured and (coverage < 1.0 or len(name.tokens) < 3):
        return None  # "24 Hour Fitness" is no measure
    whole = sum(h.last - h.first for _, _, h in chosen) == len(name.tokens)
    if not distinctive:
        kind = len(name.tokens) == 1 and (
            _is_kind_word(name.tokens[0]) or words[first].low in lexicon().stop
        )
        if not whole or kind or (len(name.tokens) == 1 and not _stands(words, first, name, roles)):
            return None
    elif len(distinctive) > 1:
        if not _words_suffice(words, name, distinctive, coverage, roles):
            return None
    elif not _one_word_suffices(words, name, chosen, distinctive[0], coverage, roles):
        return None
    if _compass_conflict(words, name, chosen):
        return None
    kernel = tuple(i for spot in distinctive or chosen for i in range(spot[0], spot[1]))
    matched -= sum(  # what everyone says tells nothing: "of Ateneum" is no "Facade of Ateneum"
        name.weights[p]
        for _, _, h in chosen
        for p in range(h.first, h.last)
        if name.tokens[p] in lexicon().stop and len(distinctive) == 1
    )
    return _Fit(first, last, name.landmark, matched, coverage, kernel)


def _words_suffice(
    words: Sequence[Word],
    name: Name,
    distinctive: list[tuple[int, int, Hit]],
    coverage: float,
    roles: Roles,
) -> bool:
    """Whether two or more words of a name tell enough of it."""
    if coverage < 1.0 and all(words[spot[0]].low in lexicon().closed for spot in distinctive):
        return False
    exact = [spot for spot in distinctive if spot[2].similarity == 1.0]
    rare = [spot for spot in exact if not is_common(words[spot[0]].low)]
    if coverage < _ACCEPT:
        headed = distinctive[-1][2].last == len(name.tokens) and coverage >= _ACCEPT_HEADED
        begun = distinctive[0][2].first == 0 and coverage >= _ACCEPT_HEADED
        if begun and len(exact) == len(distinctive) and all(roles.capital[s[0]] for s in exact):
            return True  # "Legal Aid" for "Legal Aid Society of Cleveland"
        return bool(exact) and coverage >= _ACCEPT_RARE and (headed or bool(rare))
    if rare or coverage >= _ALONE:
        return bool(exact) or coverage >= _ALONE
    return bool(exact) and (len(exact) > 1 or roles.named(distinctive[0][0]))


def _one_word_suffices(
    words: Sequence[Word],
    name: Name,
    chosen: list[tuple[int, int, Hit]],
    distinctive: tuple[int, int, Hit],
    coverage: float,
    roles: Roles,
) -> bool:
    """Whether one word, perhaps with words that say little, tells enough of a name.

    An ordinary word does so only where the writer marks it as a name or puts it where a place
    belongs; a word that is spelt otherwise only there, and never when it is a word of its own.
    """
    at, end, hit = distinctive
    word, token = words[at], name.tokens[hit.first]
    led = chosen[0][0]
    named = roles.capital[at] or roles.named(led)
    known = lexicon()
    torn = end - at > 1 or hit.last - hit.first > 1
    content = sum(t not in known.stop for t in name.tokens)
    company = sum(name.tokens[s[2].first] not in known.stop for s in chosen) > 1
    if hit.similarity < 1.0:
        if company and coverage >= _ACCEPT:
            return roles.capital[at] or not is_ordinary(word.low)
        slip = hit.similarity >= _ALONE and len(token) >= 5 and named
        return slip and not is_ordinary(word.low) and coverage >= _ACCEPT_RARE
    if hit.last - hit.first == content or (company and coverage >= 1.0):
        return torn or company or _stands(words, at, name, roles)
    if torn:
        return coverage >= _ACCEPT
    if token in known.classes or (token in known.closed | known.common and not company):
        return False
    if word.low in ALWAYS_CAPITAL and not company:
        return False
    if _ordinal(words, at) and not (company or named):
        return False
    headed = company and chosen[-1][2].last == len(name.tokens) and not roles.indefinite[led]
    if headed and roles.placed[led] and word.low not in PERSONS and coverage >= _ACCEPT_RARE:
        return not is_kind_noun(" ".join(words[k].low for k in range(led, chosen[-1][1])))
    if not is_common(word.low):
        return coverage >= _ACCEPT_RARE and (
            not is_ordinary(word.low) or roles.capital[at] or (named and coverage >= _ACCEPT)
        )
    if word.low in PERSONS or coverage < _ACCEPT or roles.indefinite[at]:
        return False
    if company and (roles.placed[led] or all(words[s[0]].text[:1].isupper() for s in chosen)):
        return True
    if roles.cased:
        return roles.capital[at]
    return roles.placed[led] and word.low not in BARE and not _followed(words, end, name)


def _stands(words: Sequence[Word], at: int, name: Name, roles: Roles) -> bool:
    """Whether a word may be the whole of a name where it stands."""
    word = words[at]
    spelt = [w for w in name.spelt if w not in lexicon().stop]
    others = (w for k, w in enumerate(words) if k != at)
    if len(words) < _ANSWER and all(w.kind == "mark" or w.low == "the" for w in others):
        return True  # nothing else was said: an answer
    if word.kind == "number" and word.low.isdigit():
        return roles.numbered[at] or roles.placed[at]
    if not is_common(word.low) and not (word.low in PERSONS or word.low in lexicon().closed):
        return True
    plain = word.low.removesuffix("'s")
    if plain not in [w.replace("'s", "") for w in spelt]:
        return False
    if roles.capital[at]:
        return True
    if word.text[:1].isupper() and not roles.indefinite[at]:
        after = words[at + 1].low if at + 1 < len(words) else "."
        known = lexicon()
        begins = after in known.copula or after in known.longest_cues or not after.isalnum()
        return begins and word.low not in PERSONS and word.low not in known.closed
    return (
        roles.placed[at]
        and not roles.indefinite[at]
        and word.low not in PERSONS
        and word.low not in BARE
        and word.low not in lexicon().object_kinds
        and not _followed(words, at + 1, name)
    )


def _followed(words: Sequence[Word], at: int, name: Name) -> bool:
    """Whether a noun follows that is no part of a name: "near the chase car"."""
    if at >= len(words) or words[at].kind != "word":
        return False
    known, low = lexicon(), words[at].low
    if (
        canonical(low) in name.tokens
        or canonical(low) in known.generic
        or low in known.longest_places
    ):
        return False
    return low not in known.closed or low in known.object_kinds


def _ordinal(words: Sequence[Word], at: int) -> bool:
    """Whether "third" or "2nd" counts a thing ("the third floor") rather than names a street."""
    low = words[at].low
    if low not in lexicon().ordinals and not (low[:1].isdigit() and low[-1:].isalpha()):
        return False
    if at + 1 >= len(words) or words[at + 1].kind != "word":
        return low in lexicon().ordinals
    after = words[at + 1].low
    counts = is_ordinary(after) and after not in lexicon().closed
    return counts or low in lexicon().ordinals


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


def _preference(fit: _Fit) -> tuple[float, float, int, int]:
    return -round(fit.matched, 3), -round(fit.coverage, 3), fit.first, fit.landmark


def _choose(fits: list[_Fit], n_words: int) -> list[LandmarkMention]:
    """Keep the fits that explain most, none overlapping; others of the same words share it."""
    taken: list[int] = [-1] * n_words
    chosen: list[list[_Fit]] = []
    rivals: list[list[int]] = []
    for fit in fits:
        owners = {taken[w] for w in range(fit.first, fit.last)} - {-1}
        if not owners:
            for w in range(fit.first, fit.last):
                taken[w] = len(chosen)
            chosen.append([fit])
            rivals.append([])
        elif len(owners) == 1:
            owner = owners.pop()
            if any(fit.landmark == f.landmark for f in chosen[owner]):
                continue
            if fit.landmark in rivals[owner]:
                continue
            best = chosen[owner][0]
            if fit.kernel == best.kernel and best.matched - fit.matched < _SAME_WORDS:
                chosen[owner].append(fit)
            else:
                rivals[owner].append(fit.landmark)
    mentions = [_mention(same, others) for same, others in zip(chosen, rivals, strict=True)]
    return sorted(mentions, key=lambda m: m.first)


def _mention(fits: list[_Fit], rivals: list[int]) -> LandmarkMention:
    """Return what the same words may name, each with its share."""
    best = fits[0]
    ties = [
        f
        for f in fits
        if (f.first, f.last) == (best.first, best.last) and best.coverage - f.coverage < _TIE
    ]
    rest = [f.landmark for f in fits if f not in ties]
    shares = referents({f.landmark: min(1.0, f.coverage) for f in fits})
    return LandmarkMention(
        best.first,
        best.last,
        tuple(f.landmark for f in ties),
        min(1.0, best.coverage),
        (*rest, *rivals),
        shares,
    )
