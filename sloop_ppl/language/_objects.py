"""Find what a text speaks of by its role: who speaks, persons, and things that nobody declared.

An object is a noun phrase that is (or may be) somewhere: the subject of being ("the food truck is
behind ..."), what is seen, lost, left, parked or found, or what opens a telegram ("food truck:
...").  Words that are read as verbs, times or abstract nouns head none.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from sloop_ppl.language.figures import FigureMention, inferred_target
from sloop_ppl.language.lexicon import Lexicon, lexicon
from sloop_ppl.language.values import SPEAKER, TargetObject
from sloop_ppl.language.words import Word

__all__ = ["Objects", "find_objects", "find_speaker", "own_cars"]

_LONGEST_PHRASE = 5
_LEADS_TO_PLACES = frozenset(("no", "less", "more", "where", "about", "around", "exactly"))
_LOOK_AHEAD = 8  # words between "we" and what says where: "we are all still sitting right"
_ON_THE_WAY = frozenset(("on", "over", "down", "up", "straight", "right", "directly"))
_DEFINITE = frozenset(("the", "this", "that"))
_CLAUSE_MARKS = frozenset(".;!?:,()[]-–—\n")


def _words(role: str) -> frozenset[str]:
    return lexicon().words_of(role)


@dataclass(frozen=True)
class Objects:
    """Mentions of objects, and the objects among them that no one declared."""

    mentions: tuple[FigureMention, ...]
    inferred: tuple[TargetObject, ...] = ()


def find_speaker(norms: Sequence[str], taken: Sequence[bool]) -> list[FigureMention]:
    """Return the mentions of who speaks that say where he is: "I'm at", "meet me", "we parked".

    "I think the bike ..." says nothing of the speaker's place and is none.
    """
    known = lexicon()
    found: list[FigureMention] = []
    for i in range(len(norms)):
        if taken[i]:
            continue
        if _is_speaker(norms, taken, i, known):
            found.append(FigureMention(i, i + 1, (SPEAKER,)))
    return found


def _is_speaker(norms: Sequence[str], taken: Sequence[bool], i: int, known: Lexicon) -> bool:
    """Whether a word stands for who speaks, where it is said where he is or will be."""
    norm, before, after = norms[i], norms[max(0, i - 1) : i], norms[i + 1 : i + 2]
    if norm in known.words_of("speaker"):
        here = before == ["where"] and (norm in ("i'm", "we're") or after in (["am"], ["are"]))
        return here or _says_where(norms, taken, i + 1, known)  # "east of where we are"
    if norm in ("me", "us"):
        meets = bool(before) and before[0] in known.words_of("meet_verbs")
        joins = before == ["with"] and "meet" in norms[max(0, i - 4) : i]  # "meet up with me"
        return joins or (meets and not _object_follows(norms, i + 1, known))
    if norm == "come":
        return _reaches(norms, i + 1)
    if norm == "meet":  # "meet at the bank"
        return _cue_at(norms, i + 1, known)
    if norm == "you" and before == ["see"] and norms[i - 2 : i - 1] not in (["i"], ["can"]):
        return _cue_at(norms, i + 1, known)  # "see you by the bank"
    if norm in ("let's", "lets"):
        return bool(known.words_of("outings") & set(norms[i + 1 : i + 4]))
    return norm in ("location", "position", "meeting") and _my(norms, i)


def _reaches(norms: Sequence[str], at: int) -> bool:
    """Whether "come" is an invitation to a place: "come to the bank", "come over to Rumor"."""
    while at < len(norms) and norms[at] in _ON_THE_WAY:
        at += 1
    following = norms[at] if at < len(norms) else ""
    return following in ("to", "by") and not any(w in ("from", "out") for w in norms[at - 1 : at])


def _my(norms: Sequence[str], i: int) -> bool:
    before = norms[i - 1] if i else ""
    return before in ("my", "our") or (
        norms[i] == "meeting" and norms[i + 1 : i + 2] in (["point"], ["place"])
    )


def _object_follows(norms: Sequence[str], at: int, known: Lexicon) -> bool:
    """Whether "get me" is followed by what is to be got."""
    following = norms[at] if at < len(norms) else ""
    return following in known.words_of("possessive") or following in ("a", "an", "the", "some")


def _says_where(norms: Sequence[str], taken: Sequence[bool], at: int, known: Lexicon) -> bool:
    """Whether words after "I" lead to where he is: states and small words, then a cue."""
    states = known.words_of("state_verbs")
    be = norms[at - 1] in ("i'm", "im", "we're") or "'" in norms[at - 1]
    for k in range(at, min(at + _LOOK_AHEAD, len(norms))):
        if taken[k]:
            return be and k > at
        norm = known.short.get(norms[k], norms[k])
        starts = (
            norm in _LEADS_TO_PLACES
            or known.alike.get(norm, norm) in known.longest_cues
            or norm in known.directions or norm in known.numbers
            or norm.isdigit() or norm in ("nowhere", "near")
        )  # fmt: skip
        if be and starts and (norm not in states or _cue_at(norms, k, known)):
            return True
        arrived = _words("arriving")
        ahead = norms[k + 1] if k + 1 < len(norms) else ""
        if (norm in ("have", "had") and ahead in arrived) or (
            norm in arrived and _after_have(norms, k)
        ):
            be = True  # "I have pulled over on"
            continue
        if norm in known.classes and "be" in known.classes[norm]:
            be = be or norm not in ("has", "have", "had", "seen", "found", "spotted")
            if (
                norm in states
                or norm in known.copula
                or norm in ("standing", "will", "would", "should")
            ):
                continue
            return False
        if norm in states or norm in known.words_of("neg") or norm in known.intensifiers:
            be = be or norm in known.words_of("staying")
            continue
        if norm in ("'s", ",") or (norm in ("you", "for", "here") and k > at):
            continue
        return False
    return False


def _after_have(norms: Sequence[str], k: int) -> bool:
    """Whether "have" stands before a word."""
    return k > 0 and (norms[k - 1] in ("have", "had") or norms[k - 1].endswith("'ve"))


def _cue_at(norms: Sequence[str], at: int, known: Lexicon) -> bool:
    if at >= len(norms):
        return False
    reach = known.longest_cues.get(norms[at], 0)
    found = any(tuple(norms[at : at + n]) in known.cues for n in range(1, reach + 1))
    return found or norms[at] in known.directions


def own_cars(norms: Sequence[str], mentions: Sequence[FigureMention]) -> list[FigureMention]:
    """Return mentions with "the red car" as a car of its own where no default object is meant.

    RedHonda is meant where a make is said or another default object is spoken of; a red car alone
    is any. "The green car" stays GreenToyota, as the project's own sets have it.
    """
    spoken = {c for m in mentions for c in m.candidates if c in _DEFAULT_IDS}
    makes = {"toyota", "honda"}
    if spoken != {"RedHonda"} or any(_bare(n) in makes for n in norms):
        return list(mentions)
    changed = []
    for mention in mentions:
        if mention.back or not set(mention.candidates) & spoken:
            changed.append(mention)
            continue
        target = inferred_target([_bare(n) for n in norms[mention.first : mention.last]])
        changed.append(replace(mention, candidates=(target.id,)))
    return changed


def find_objects(
    words: Sequence[Word],
    norms: Sequence[str],
    taken: Sequence[bool],
    mentions: Sequence[FigureMention],
) -> Objects:
    """Return the mentions of objects that no one declared, and those given, widened.

    Parameters
    ----------
    words, norms
        The text, as it stands and with its spelling mended.
    taken
        Whether each word is part of a landmark's name or of a kind of place.
    mentions
        Mentions of objects of known kinds ("van", "red bike"), which modifiers may widen.
    """
    finder = _ObjectFinder(words, norms, taken)
    given = {m.first: m for m in mentions}
    phrases = finder.phrases({m.first: m.last for m in mentions})
    objects: dict[str, TargetObject] = {}
    found: list[FigureMention] = []
    waiting: list[FigureMention] = []
    for phrase in phrases:
        target = finder.target(phrase)
        inside = [given[k] for k in range(phrase.first, phrase.last) if k in given]
        if inside and any(finder.is_predicate(m.first) for m in inside):
            for m in inside:
                given.pop(m.first)
            continue
        if inside:
            keeps = all(len(c) and c in _DEFAULT_IDS for m in inside for c in m.candidates)
            if keeps or any(m.back or m.other or m.plural for m in inside):
                continue  # a default object, or words that point back
            mention = FigureMention(phrase.first, phrase.last, (target.id,))
            objects.setdefault(target.id, target)
            found.append(mention)
            for m in inside:
                given.pop(m.first)
            continue
        mention = FigureMention(phrase.first, phrase.last, (target.id,))
        if phrase.role:
            objects.setdefault(target.id, target)
            found.append(mention)
        elif phrase.definite:
            waiting.append(mention)
    # A phrase without a role is an object where the same words have one elsewhere: "next to Tom.
    # Tom is on a bench", "in my truck".
    found += [mention for mention in waiting if mention.candidates[0] in objects]
    longer = {
        _bare(norms[m.last - 1]): m for m in waiting if m.last - m.first > 1 and m not in found
    }
    for k, mention in enumerate(found):  # "the security guard. The guard is at ..."
        full = longer.get(_bare(norms[mention.last - 1]))
        if full is not None and mention.last == mention.first + 1 and full.first < mention.first:
            short = objects.pop(mention.candidates[0], None)
            if short is not None:
                objects[full.candidates[0]] = replace(short, id=full.candidates[0])
                found[k] = replace(mention, candidates=full.candidates)
                found.append(full)
    found = _same_heads(norms, found, objects)
    found += [m for m in given.values() if not any(f.first <= m.first < f.last for f in found)]
    return Objects(tuple(sorted(found, key=lambda m: m.first)), tuple(objects.values()))


def _same_heads(
    norms: Sequence[str], found: list[FigureMention], objects: dict[str, TargetObject]
) -> list[FigureMention]:
    """Return mentions with "the guard" as the security guard that was spoken of before."""
    kept: list[FigureMention] = []
    full: dict[str, list[str]] = {}  # head -> the objects that it was said of with other words
    for mention in sorted(found, key=lambda m: m.first):
        head = _bare(norms[mention.last - 1])
        alone = mention.last == mention.first + 1 and norms[mention.first - 1] in _DEFINITE
        ids = full.setdefault(head, [])
        while ids and ids[-1] not in objects:
            ids.pop()
        if alone and mention.first and ids and mention.candidates[0] in objects:
            del objects[mention.candidates[0]]
            mention = replace(mention, candidates=(ids[-1],))
        kept.append(mention)
        if mention.last - mention.first > 1:
            ids.append(mention.candidates[0])
    return kept


_DEFAULT_IDS = frozenset(("GreenToyota", "RedHonda", "RedBike"))


@dataclass(frozen=True, slots=True)
class _Phrase:
    """A noun phrase without its article.

    Parameters
    ----------
    first, last
        Half-open range of words.
    lead
        The article or possessive before it, "" without one.
    role
        Whether it is spoken of as something that is somewhere.
    definite
        Whether it may point back to the same words.
    """

    first: int
    last: int
    lead: str
    role: bool
    definite: bool


@lru_cache(maxsize=4)
def _closed_words(known: Lexicon) -> tuple[frozenset[str], frozenset[str], frozenset[str]]:
    """Return the words that end a noun phrase, those that head none, and those of places."""
    function = (
        frozenset(known.classes)
        | frozenset(known.directions)
        | frozenset(known.units_m)
        | known.intensifiers
        | frozenset(w for w in known.longest_cues if w not in ("front", "back"))
    )
    roles = ("ordinary_verbs", "adverbs", "times", "abstract", "speaker", "locating_verbs")
    no_head = frozenset(w for role in roles for w in known.words_of(role))
    return function, no_head, frozenset(w for phrase in known.place_phrases for w in phrase)


class _ObjectFinder:
    """Cuts noun phrases out of the words that nothing else has taken."""

    def __init__(self, words: Sequence[Word], norms: Sequence[str], taken: Sequence[bool]) -> None:
        self.words = words
        self.norms = norms
        self.taken = taken
        self.known = lexicon()
        self._function, self._no_head, self._place_words = _closed_words(self.known)
        self.ends: frozenset[str] = frozenset()  # last words of subjects

    def phrases(self, known_last: dict[int, int]) -> list[_Phrase]:
        """Return the noun phrases in order, with their roles."""
        found: list[_Phrase] = []
        i = 0
        while i < len(self.norms):
            phrase = self._phrase(i, known_last)
            if phrase is None:
                i += 1
            else:
                found.append(phrase)
                i = phrase.last
        self.ends = frozenset(self.norms[p.last - 1] for p in found if p.role)
        found = self._appositions(found)
        for k in range(len(found) - 1, 0, -1):  # "the ladder, the hose and the axe are in ..."
            before, after = found[k - 1], found[k]
            start = after.first - bool(after.lead)
            if (
                after.role
                and not before.role
                and before.definite
                and self._listed(before.last, start)
            ):
                found[k - 1] = replace(before, role=True)
        return found

    def _appositions(self, found: list[_Phrase]) -> list[_Phrase]:
        """Return phrases with "Biscuit, our beagle, was ..." as one, the name."""
        kept: list[_Phrase] = []
        for phrase in found:
            before = kept[-1] if kept else None
            named = before is not None and not before.lead and self._starts_clause(before.first)
            start = phrase.first - bool(phrase.lead)
            explains = (
                named
                and before is not None
                and phrase.lead not in ("", "the")
                and self.norms[before.last : start] == [","]
                and self.norms[phrase.last : phrase.last + 1] == [","]
                and self.norms[phrase.last + 1 : phrase.last + 2]
                and self.norms[phrase.last + 1] in self.known.words_of("be")
            )
            if explains and before is not None:
                kept[-1] = replace(before, role=True)
            else:
                kept.append(phrase)
        return kept

    def _listed(self, first: int, last: int) -> bool:
        """Whether only a comma or "and" stands between two phrases."""
        between = self.norms[first:last]
        return 0 < len(between) <= 2 and all(w in (",", "and", "&", "+") for w in between)

    def target(self, phrase: _Phrase) -> TargetObject:
        """Return the object that a phrase names."""
        names = [_bare(self.norms[k]) for k in range(phrase.first, phrase.last)]
        names = [re.sub(r"\W", "", n) for n in names]
        names = [n for n in names if n]
        head = phrase.last - 1
        kin = [k for k, n in enumerate(names[:-1]) if n in self.known.words_of("kin")]
        if kin:  # "my friend Anna" is Anna
            names = names[kin[-1] + 1 :]
        person = bool(kin) or (
            self.words[head].text[:1].isupper()
            and names[-1] not in self.known.object_kinds
            and not self._starts_clause(phrase.first)
            and not self.words[head].text.isupper()
        )
        mine = "my" if phrase.lead == "my" and not person else ""
        return inferred_target(names, mine)

    def _open(self, i: int) -> bool:
        """Whether a word may be part of a noun phrase."""
        word, norm = self.words[i], self.norms[i]
        if self.taken[i] and not self._compound(i):
            return False
        bare = _bare(norm)
        if word.kind == "number":
            return False
        if bare in self.known.colours or bare in self.known.object_kinds:
            return True
        if bare in _words("abstract") | _words("times"):  # "block party", "night guard"
            return (
                i + 1 < len(self.norms)
                and not self.taken[i + 1]
                and (i > 0 and self.norms[i - 1] in _words("object_determiners"))
                and self.words[i + 1].kind == "word"
                and self._open(i + 1)
            )
        return (
            word.kind == "word"
            and bare not in self._function
            and bare not in self._no_head
            and (len(bare) > 1 or word.text.isupper())
        )

    def _compound(self, i: int) -> bool:
        """Whether a kind of place only modifies an object: "school bus", "hotel shuttle"."""
        if not self.taken[i] or self.norms[i] not in self._place_words:
            return False
        if i and self.taken[i - 1]:
            return False
        following = self.norms[i + 1] if i + 1 < len(self.norms) else ""
        return (
            bool(following)
            and not self.taken[i + 1]
            and _bare(following) in self.known.object_kinds
        )

    def _phrase(self, i: int, known_last: dict[int, int]) -> _Phrase | None:
        lead = (
            self.norms[i]
            if self.norms[i] in _words("object_determiners") and not self.taken[i]
            else ""
        )
        first = i + 1 if lead else i
        at = first
        attached = False  # the last word ends in 's, which stands for "is"
        while at < len(self.norms) and at - first < _LONGEST_PHRASE:
            if (
                self.words[at].low == "."
                and at > first
                and self.norms[at - 1] in self.known.words_of("titles")
            ):
                at += 1
                continue
            sized = self.norms[at] in self.known.words_of("size_adjectives") and at + 1 < len(
                self.norms
            )
            if not (
                self._open(at)
                or (sized and not self.taken[at] and (lead or at > first or self._open(at + 1)))
            ):
                break
            if at in known_last and at == first and known_last[at] > at + 1:
                at = known_last[at]
                attached = self.norms[at - 1].endswith("'s")
                if attached:
                    break
                continue
            at += 1
            if self.norms[at - 1].endswith("'s"):
                if self._possesses(at):
                    first, lead = at, "the"
                    continue
                attached = True
                break
        last = at
        while last > first and not self._heads(last - 1):
            last -= 1
        if last <= first or any(
            self.taken[k] and not self._compound(k) for k in range(first, last)
        ):
            return None
        if not lead and last == first + 1 and self._participle(first):
            return None
        begin = first
        while begin < last - 1 and self.norms[begin] in self.known.words_of("size_adjectives"):
            begin += 1
        role = self._has_role(i, begin, last, lead, attached)
        named = self.words[last - 1].text[:1].isupper() or _bare(
            self.norms[last - 1]
        ) in self.known.words_of("kin")
        return _Phrase(begin, last, lead, role, bool(lead) or named)

    def _participle(self, k: int) -> bool:
        """Whether a word alone is a verb's form: "squeezed between", "heading to"."""
        norm = self.norms[k]
        upper = self.words[k].text[:1].isupper() and not self._starts_clause(k)
        return norm.endswith(("ed", "ing")) and not upper and norm not in self.known.object_kinds

    def _hyphen(self, at: int, first: int) -> bool:
        """Whether a word goes on after a hyphen: "U-Haul", "two-seater"."""
        return (
            at > first
            and self.words[at].low == "-"
            and not self.words[at].spaced
            and at + 1 < len(self.words)
            and not self.words[at + 1].spaced
            and self.words[at + 1].kind == "word"
            and not self.taken[at + 1]
        )

    def _heads(self, k: int) -> bool:
        """Whether a word can head a phrase."""
        bare = _bare(self.norms[k])
        titled = k > 1 and self.known.words_of("titles") & {self.norms[k - 1], self.norms[k - 2]}
        if bare in self.known.object_kinds or titled:
            return True
        return (
            bare not in self.known.colours
            and bare not in self.known.words_of("size_adjectives")
            and bare not in self.known.words_of("titles")
            and self.words[k].kind == "word"
            and not self.taken[k]
            and bare not in self._no_head
            and bare not in self._place_words - self.known.words_of("kin")
        )

    def _possesses(self, at: int) -> bool:
        """Whether 's before a word marks an owner: "the suspect's car"."""
        if at >= len(self.norms) or self.taken[at]:
            return False
        bare = _bare(self.norms[at])
        return (
            (self._open(at) and bare not in self.known.closed)
            or bare in self.known.object_kinds
            or bare in self.known.colours
        )

    def _starts_clause(self, i: int) -> bool:
        """Whether nothing of the clause stands before a word."""
        if i == 0 or self.words[i].breaks:
            return True
        return self.words[i - 1].kind == "mark" and self.words[i - 1].low in _CLAUSE_MARKS

    def _has_role(self, start: int, first: int, last: int, lead: str, attached: bool) -> bool:
        known = self.known
        before = self.norms[start - 1] if start else ""
        begins = self._starts_clause(start)
        named = (
            (self.words[last - 1].text[:1].isupper() and not self._starts_clause(first))
            or _bare(self.norms[last - 1]) in known.words_of("kin")
            or _bare(self.norms[last - 1]) in known.object_kinds
        )
        free = bool(lead) or named or begins or before in _words("clause_openers")
        if (
            before in ("of", "with")
            and self.norms[start - 2 : start - 1]
            and self.norms[start - 2] in _words("traces")
        ):
            return True
        if self._located(start):
            return (
                bool(lead) or named or self.norms[last - 1].endswith("s") or self._cue_starts(last)
            )
        if before in _words("addressing"):
            return False  # "tell Dave the truck is"
        if before in ("of", "to", "from") and self._turned(start):
            return True
        prepositions = before in known.longest_cues or before in _words("prepositions")
        if prepositions and not attached:
            return self._relative(last)
        if not free:
            return False
        if self._is_after(last, attached) or self._resumed(last):
            return True
        if begins and (lead or named) and self._goes_on(last):
            return True
        return begins and self._telegram(last)

    def _turned(self, start: int) -> bool:
        """Whether a place is the subject: "Gotham Condos are northwest of our camper"."""
        first = start - 1
        while first > 0 and not self._starts_clause(first):
            first -= 1
        if self.norms[first] in _words("object_determiners"):
            first += 1
        onward = first
        while onward < start and self.taken[onward]:
            onward += 1
        return onward > first and self.norms[onward] in self.known.words_of("be")

    def _relative(self, last: int) -> bool:
        """Whether ", which is" follows a phrase."""
        at = last + 1 if self.norms[last : last + 1] == [","] else last
        following = self.norms[at : at + 2]
        return (
            len(following) == 2
            and following[0] in ("which", "that", "who")
            and following[1] in self.known.words_of("be")
        )

    def _goes_on(self, last: int) -> bool:
        """Whether more is said of the subject, then where it is: "the rider whose ... is by"."""
        following = self.norms[last] if last < len(self.norms) else ""
        led = following in _words("subject_goes_on")
        if not (led or following in self.known.words_of("ordinary_verbs")):
            return False
        end = last
        while end < len(self.norms) and self.words[end].low not in (".", ";", "!", "?"):
            if self._cue_starts(end) and end > last:
                return True
            end += 1
        return False

    def is_predicate(self, first: int) -> bool:
        """Whether a phrase says what someone is: "I'm an old woman"."""
        at = first - 1
        while at >= 0 and (
            self.norms[at] in self.known.words_of("size_adjectives")
            or self.norms[at] in ("a", "an")
        ):
            at -= 1
        speaker = self.known.words_of("speaker")
        be = (
            at > 0
            and self.norms[at] in ("am", "are", "was", "were")
            and self.norms[at - 1] in speaker
        )
        if at >= 0 and at < first - 1 and (be or self.norms[at] in ("i'm", "we're")):
            return True
        lead = first - 1
        while lead >= 0 and (
            self.norms[lead] in self.known.words_of("size_adjectives")
            or self.norms[lead] in ("a", "an", "the", "first", "third", "last", "only")
        ):
            lead -= 1
        names = self.norms[lead - 1] if lead > 0 else ""
        is_one = lead > 0 and lead < first - 1 and self.norms[lead] in ("is", "are", "was", "were")
        return is_one and names in self.ends

    def _resumed(self, last: int) -> bool:
        """Whether a pronoun takes a phrase up: "our group she is", "my bike I left it"."""
        following = self.norms[last : last + 2]
        if len(following) < 2:
            return False
        says = following[0] in ("says", "said", "texted", "thinks", "writes", "reports", "called")
        if says:
            return following[1] in ("he", "she", "he's", "she's", "it", "it's", "they", "they're")
        verb = following[1] in self.known.words_of("be") | self.known.words_of("locating_verbs")
        return following[0] in ("he", "she", "it", "they", "i", "we") and verb

    def _located(self, start: int) -> bool:
        """Whether what stands before a phrase sees, loses or leaves it, or says it exists."""
        at = start - 1
        steps = 0
        while at >= 0 and steps < 2 and self.norms[at] in _words("object_particles"):
            at -= 1
            steps += 1
        if at < 0 or self.taken[at]:
            return False
        norm = self.norms[at]
        if norm in _words("existential"):
            return True
        if norm in ("is", "are", "was", "were", "be", "been", "isn't", "aren't", "wasn't") and at:
            back = self.norms[at - 1] in ("no", "not") and at > 1
            return self.norms[at - 2 if back else at - 1] in _words("existential") | {"where"}
        if norm in ("looking", "searching", "look", "search", "hunting") and steps:
            return True
        if norm == "no" and at:
            return self._located(at)
        if norm in ("have", "has", "had"):  # "has a van", no "have leaved"
            return self.norms[start] in _words("object_determiners")
        if norm in self.known.words_of("locating_verbs"):
            return True
        if norm in ("me", "us", "him", "her", "them", "it"):
            return False
        return False

    def _is_after(self, last: int, attached: bool) -> bool:
        """Whether a phrase is followed by being somewhere, "of my wife" and such passed over."""
        known = self.known
        at = last
        if attached:
            return True
        if self.norms[at : at + 1] in (["of"], ["with"], ["from"]) and not attached:
            k = at + 1
            while (
                k < len(self.norms)
                and k - at < 5
                and (self.norms[k] in _words("object_determiners") or self._open(k))
            ):
                k += 1
            at = k if k > at + 1 else at
        steps = 0
        while (
            at < len(self.norms)
            and steps < 3
            and not self.taken[at]
            and (
                self.norms[at] in known.words_of("adverbs")
                or self.norms[at] in known.intensifiers
                or self.norms[at] in ("all",)
            )
            and self.norms[at] not in known.longest_cues
        ):
            at += 1
            steps += 1
        if at >= len(self.norms) or self.taken[at]:
            return False
        norm = self.norms[at]
        classes = known.classes.get(norm, frozenset())
        if "be" in classes and norm != "'s":
            if norm not in ("have", "has", "had"):
                return True
            onward = at + 2  # "has been", "has set up at"
            if self.norms[onward : onward + 1] and self.norms[onward] in _words("object_particles"):
                onward += 1
            return self.norms[at + 1 : at + 2] == ["been"] or self._cue_starts(onward)
        if "neg" in classes:
            return True
        if norm in _words("staying"):
            return True
        if norm in known.words_of("ordinary_verbs"):
            onward = at + 1
            particles = _words("object_particles") | {"off", "into"}
            if onward < len(self.norms) and self.norms[onward] in particles:
                onward += 1
            stuck = self.norms[onward] if onward < len(self.norms) else ""
            if stuck in known.words_of("be") or (stuck.endswith("ed") and norm in ("got", "gets")):
                onward += 1  # "got stuck near"
            return onward < len(self.norms) and (
                self._cue_starts(onward) or self.norms[at + 1 : at + 2] == ["into"]
            )
        return self._cue_starts(at) and steps == 0 and (self._starts_clause(last) is False)

    def _cue_starts(self, at: int) -> bool:
        if at >= len(self.norms) or self.taken[at]:
            return False
        return _cue_at(self.norms, at, self.known)

    def _telegram(self, last: int) -> bool:
        """Whether ":" or "," and a place, or a place itself, follows an opening phrase."""
        if last >= len(self.norms):
            return False
        if self.words[last].kind == "mark" and self.words[last].low in ":,-–—=>":
            at = last + 1
            return at < len(self.norms) and (
                self.taken[at] or self._cue_starts(at) or self.words[at].kind == "number"
            )
        return self._cue_starts(last)


def _bare(norm: str) -> str:
    return norm[:-2] if norm.endswith("'s") else norm
