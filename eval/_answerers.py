"""People who answer in the evaluation: an oracle, one who sees the city otherwise, a recorded one.

Their answers are drawn from streams named after description, target and question, so that all
models meet the same person.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import shapely

from sloop_ppl.bridge.asking import AnswererModel
from sloop_ppl.bridge.asking.question import DONT_KNOW
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.language import NOT_ON_MAP, Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking import Question
    from sloop_ppl.inference import AnswerFactor

__all__ = ["ANSWERERS", "AskingSettings", "OracleAnswerer", "PersonAnswerer", "RecordedAnswerer",
           "held_back", "recorded_relations", "speaker_place"]  # fmt: skip

ANSWERERS = ("a", "b", "c")
"""Oracle geometry; another family's geometry, with the speaker's mistakes; what was recorded."""

CHOICES = ("planned", "random", "fixed")
"""How questions are chosen: by expected reward, any, or the side of the first ground."""

_CELL_KINDS = ("side", "nearer", "inside", "street", "distance")
_MEANING_KINDS = ("referent", "reading")


@dataclass(frozen=True)
class AskingSettings:
    """How a sweep asks.

    Parameters
    ----------
    answerer
        One of `ANSWERERS`.
    error
        How often answers are wrong for no reason, in [0, 1); when None 0.1 of a, and 0 of b, whose
        errors are those of its geometry.
    believed_error
        How often the program takes them to be; when None as often as `error` says, 0.1 without it.
    guess, believed_guess
        The same of answers that are guessed.
    rho
        Of answerer b: how often the person answers from where the speaker thought the target was.
    choice
        One of `CHOICES`.
    steps
        How many steps a question takes.

    Raises
    ------
    UnknownName
        For another answerer or choice.
    InputError
        When a share is out of its range.
    """

    answerer: str = "a"
    error: float | None = None
    believed_error: float | None = None
    guess: float = 0.0
    believed_guess: float | None = None
    rho: float = 0.5
    choice: str = "planned"
    steps: int = 0

    def __post_init__(self) -> None:
        if self.answerer not in ANSWERERS:
            raise UnknownName("answerer", self.answerer, ANSWERERS)
        if self.choice not in CHOICES:
            raise UnknownName("way to choose questions", self.choice, CHOICES)
        if not 0 <= self.rho <= 1:
            raise InputError(f"rho is {self.rho}; expected a share in [0, 1]")
        AnswererModel(error=self.slips, guess=self.guess)
        _ = self.person

    @property
    def slips(self) -> float:
        """How often answers are wrong for no reason."""
        return (0.1 if self.answerer == "a" else 0.0) if self.error is None else self.error

    @property
    def person(self) -> AnswererModel:
        """How the program believes the person to answer."""
        given = (e for e in (self.believed_error, self.error, AnswererModel.error) if e is not None)
        error = next(given)
        guess = self.guess if self.believed_guess is None else self.believed_guess
        if self.answerer == "a":
            return AnswererModel.exact(error, guess)
        return AnswererModel(error=error, guess=guess)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of questions that the answerer can answer."""
        if self.answerer == "c":
            return ("side", "inside", "distance")
        return (*_CELL_KINDS, *_MEANING_KINDS)

    def asks_about(self, annotated: AnnotatedDescription, target: str) -> bool:
        """Tell whether a target is searched for: c needs something that can be held back."""
        return self.answerer != "c" or len(_grounded(annotated.about(target))) > 1


def _grounded(relations: Sequence[SpatialRelation]) -> list[SpatialRelation]:
    return [r for r in relations if NOT_ON_MAP not in r.grounds]


def held_back(annotated: AnnotatedDescription, seed: int) -> dict[str, SpatialRelation]:
    """Return target -> the gold relation that answerer c keeps back, drawn by the seed."""
    found = {}
    for target in annotated.targets:
        relations = _grounded(annotated.about(target))
        if len(relations) > 1:
            rng = child(np.random.default_rng(seed), "held back", annotated.id, target)
            found[target] = relations[int(rng.integers(len(relations)))]
    return found


def without(description: Description, relations: Sequence[SpatialRelation]) -> Description:
    """Return a description without some of its relations, in every reading."""
    keys = [(r.figure, r.relation, r.grounds, r.negated) for r in relations]

    def left(some: Sequence[SpatialRelation]) -> tuple[SpatialRelation, ...]:
        return tuple(r for r in some if (r.figure, r.relation, r.grounds, r.negated) not in keys)

    readings = tuple(replace(h, relations=left(h.relations)) for h in description.readings)
    return replace(description, relations=left(description.relations), readings=readings)


def recorded_relations(
    annotated: AnnotatedDescription, others: Sequence[AnnotatedDescription], seed: int
) -> dict[str, tuple[SpatialRelation, ...]]:
    """Return target -> what was said of it beside what the program is given.

    Parameters
    ----------
    others
        All descriptions; those of the same configuration by other people count.
    """
    own = held_back(annotated, seed)
    found = {}
    for target, relation in own.items():
        kept = [r for r in annotated.about(target) if r != relation]
        known = {(r.relation, r.grounds) for r in kept}
        more = [
            r
            for other in others
            if other.id != annotated.id
            and (other.map, other.configuration) == (annotated.map, annotated.configuration)
            and target in other.targets
            for r in _grounded(other.about(target))
            if (r.relation, r.grounds) not in known
        ]
        found[target] = (relation, *more)
    return found


class OracleAnswerer:
    """Answerer a: who sees where the target is, and errs now and then.

    Parameters
    ----------
    annotated
        The description, whose gold tells what was meant.
    target
        Id of the target.
    cell
        Row and column of its true cell.
    error, guess
        How often an answer is another one, and is guessed.
    rng
        The stream of this description and target.
    """

    def __init__(
        self,
        annotated: AnnotatedDescription,
        target: str,
        cell: tuple[int, int],
        *,
        error: float,
        guess: float,
        rng: np.random.Generator,
    ) -> None:
        self._annotated, self._target, self._cell = annotated, target, cell
        self._error, self._guess, self._rng = error, guess, rng

    def answer(self, question: Question) -> str:
        """Return the answer."""
        rng = child(self._rng, "answer", question.text)
        if rng.random() < self._guess:
            return question.options[int(rng.integers(len(question.options)))]
        true = meant(question, self._annotated, self._cell)
        if rng.random() < self._error:
            others = [k for k in range(len(question.options)) if k != true]
            true = others[int(rng.integers(len(others)))]
        return question.options[true]


def meant(question: Question, annotated: AnnotatedDescription, cell: tuple[int, int]) -> int:
    """Return the true option: by the place, or by the gold of what was said."""
    if question.about == "referent":
        gold = {g for r in annotated.about(question.target) for g in r.grounds}
        for k, place in enumerate(question.landmarks):
            if place in gold:
                return k
        return len(question.options) - 1
    if question.about == "reading":
        gold_pairs = {
            (r.relation, g, r.negated) for r in annotated.about(question.target) for g in r.grounds
        }
        words = _claimed(question)
        return 0 if words is None or words & gold_pairs else 1
    return int(np.argmax(question.truth_by_cell()[:, cell[0], cell[1]]))


def _claimed(question: Question) -> set[tuple[str, str, bool]] | None:
    """Return what a question of the kind reading claims."""
    from sloop_ppl.bridge.relation_text import names_of, relation_in_words

    names = names_of(question.posterior)
    for description in question.posterior.descriptions:
        for reading in description.all_readings():
            for r in reading.relations:
                if relation_in_words(r, names) in question.text:
                    return {(r.relation, g, r.negated) for g in r.grounds}
    return None


class PersonAnswerer:
    """Answerer b: who sees directions from a place's nearest wall and distances to its middle.

    Errs by a share of the distance and by some degrees, the same way whenever a landmark is spoken
    of; does not know of what is far away; and may share the speaker's mistake.

    Parameters
    ----------
    annotated, target, error, rng
        As of `OracleAnswerer`.
    place
        Where the person thinks the target is, x and y in metres.
    city
        The map.
    """

    ANGLE_DEG, DISTANCE_SHARE, FAR_M, MOST_UNKNOWN = 15.0, 0.3, 400.0, 0.5

    def __init__(
        self,
        annotated: AnnotatedDescription,
        target: str,
        place: tuple[float, float],
        city: CityMap,
        *,
        error: float,
        rng: np.random.Generator,
    ) -> None:
        self._annotated, self._place, self._city = annotated, place, city
        self._target, self._error, self._rng = target, error, rng

    def answer(self, question: Question) -> str:
        """Return the answer."""
        if question.about != "cell":
            cell = self._city.grid.cell_covering(*self._place)
            return self._slipped(question, meant(question, self._annotated, cell))
        away = max((self._seen(m)[0] for m in question.landmarks), default=0.0)
        rng = child(self._rng, "knows", *question.landmarks)
        if rng.random() < min(away / self.FAR_M, self.MOST_UNKNOWN):
            return DONT_KNOW
        return self._slipped(question, self._choice(question))

    def _slipped(self, question: Question, true: int) -> str:
        rng = child(self._rng, "answer", question.kind, *question.landmarks)
        if rng.random() < self._error:
            others = [k for k in range(len(question.options)) if k != true]
            true = others[int(rng.integers(len(others)))]
        return question.options[true]

    def _choice(self, question: Question) -> int:
        if question.kind == "street":
            return self._street(question)
        if question.kind == "nearer":
            apart = [self._seen(m)[0] for m in question.landmarks]
            return int(np.argmin(apart))
        (landmark,) = question.landmarks
        distance, direction = self._seen(landmark)
        if question.kind == "distance":
            low, high = sorted({float(n) for n in re.findall(r"\d+", " ".join(question.options))})
            return int(distance > low) + int(distance > high)
        if question.kind == "inside":
            return 0 if self._city.footprint(landmark).covers(shapely.Point(self._place)) else 1
        quarter = round(direction / (math.pi / 2)) % 4
        return (1, 0, 3, 2)[quarter]

    def _street(self, question: Question) -> int:
        """Return the street that is seen as nearest, of all parts of all streets with a name."""
        streets = [m for m in self._city.of_kind("street", "pedestrian") if m.name]
        nearest = min(streets, key=lambda m: self._seen(m.id)[0])
        labels = [self._city.landmark(m).name for m in question.landmarks]
        if nearest.name in labels:
            return labels.index(nearest.name)
        # Where no other is offered, the nearest of those that are.
        if len(question.options) > len(labels):
            return len(labels)
        among = [m for m in streets if m.name in labels]
        return labels.index(min(among, key=lambda m: self._seen(m.id)[0]).name)

    def _seen(self, landmark: str) -> tuple[float, float]:
        """Return distance and direction of the target from a landmark, as the person sees them."""
        rng = child(self._rng, "sees", landmark)
        turn, share = rng.normal(0.0, 1.0, 2)
        shape, (x, y) = self._city.footprint(landmark), self._place
        point = shapely.Point(x, y)
        own_x, own_y = self._city.centroid(landmark)
        near_x, near_y = own_x, own_y
        if not shape.contains(point):
            near = shapely.get_coordinates(shapely.shortest_line(shape, point))[0]
            near_x, near_y = float(near[0]), float(near[1])
        is_way = self._city.landmark(landmark).geometry.geom_type.endswith("LineString")
        off = shape.distance(point) if is_way else math.hypot(x - own_x, y - own_y)
        distance = off * math.exp(self.DISTANCE_SHARE * share)
        direction = math.atan2(y - near_y, x - near_x) + math.radians(self.ANGLE_DEG) * turn
        return distance, direction


def speaker_place(
    annotated: AnnotatedDescription, target: str, city: CityMap
) -> tuple[float, float]:
    """Return where the speaker thought the target was.

    Returns
    -------
    tuple of float
        x and y, metres: the true place where what was said holds of it; else the nearest cell of
        the 90 % region of the published model sloop-m4, given the gold.
    """
    from sloop_ppl.eval.quality import beliefs_of
    from sloop_ppl.inference import hpd_cells
    from sloop_ppl.models import preset

    place = annotated.targets[target]
    belief = beliefs_of(annotated, annotated.description(city), city, preset("sloop-m4"))[target]
    region, grid = hpd_cells(belief, 0.9), city.grid
    if region[place.cell]:
        return place.x_m, place.y_m
    apart = np.hypot(grid.x_m[None, :] - place.x_m, grid.y_m[:, None] - place.y_m)
    row, col = np.unravel_index(np.argmin(np.where(region, apart, np.inf)), grid.shape)
    return grid.centre_of(int(row), int(col))


@dataclass(frozen=True)
class RecordedAnswerer:
    """Answerer c: who says what someone did say, when a landmark of it is asked about.

    Parameters
    ----------
    relations
        What was recorded of the target.
    description
        What the program was given, whose objects and map the answer has.
    """

    relations: tuple[SpatialRelation, ...]
    description: Description

    @cached_property
    def topics(self) -> Mapping[str, SpatialRelation]:
        """Landmark -> what was recorded of it, the own words of who is asked first."""
        found: dict[str, SpatialRelation] = {}
        for relation in self.relations:
            for ground in relation.grounds:
                found.setdefault(ground, relation)
        return found

    def answer(self, question: Question) -> str | AnswerFactor:
        """Return what was recorded of the landmark that is asked about."""
        from sloop_ppl.bridge.relation_text import names_of, relation_in_words
        from sloop_ppl.inference import AnswerFactor

        known = [self.topics[m] for m in question.landmarks if m in self.topics]
        if not known:
            return DONT_KNOW
        words = relation_in_words(known[0], names_of(question.posterior))
        recorded = replace(
            self.description,
            text=words,
            targets=tuple(t for t in self.description.targets if t.id == question.target),
            relations=(known[0],),
            readings=(),
            unresolved=(),
        )
        return AnswerFactor(question.text, words, description=recorded)
