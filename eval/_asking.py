"""One trial of a search that may ask."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse
from sloop_ppl.eval._answerers import (
    AskingSettings,
    OracleAnswerer,
    PersonAnswerer,
    RecordedAnswerer,
    recorded_relations,
    speaker_place,
    without,
)
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.eval.trials import Searching, Trial, TrialKey
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking import CandidateQuestions, Dialogue
    from sloop_ppl.inference import Posterior

__all__ = ["AskingTrials"]

_LEAST = 1e-15


class AskingTrials:
    """The trials of one description under one model that may ask.

    Parameters
    ----------
    annotated
        The description.
    description
        What the model is given of it, before anything is held back.
    city, model
        The map and the observation model.
    searching
        How it is searched.
    asking
        How it is asked.
    recorded
        Target -> what was recorded beside, of answerer c.
    """

    def __init__(
        self,
        annotated: AnnotatedDescription,
        description: Description,
        city: CityMap,
        model: ObservationModel,
        searching: Searching,
        asking: AskingSettings,
        recorded: Mapping[str, tuple[SpatialRelation, ...]],
    ) -> None:
        self.annotated, self.description, self.city = annotated, description, city
        self.model, self.searching, self.asking = model, searching, asking
        self.recorded = recorded
        self._posteriors: dict[str, Posterior | None] = {}
        self._places: dict[str, tuple[float, float]] = {}

    def trial(self, key: TrialKey) -> Trial:
        """Search for the target of a trial, asking as often as its key allows."""
        from sloop_ppl.bridge._tracking import BeliefTracker
        from sloop_ppl.bridge.asking import PosteriorQuestioner
        from sloop_ppl.planning import run_search

        begun = time.perf_counter()
        annotated, target, grid = self.annotated, key.target, self.city.grid
        place, area = annotated.targets[target], annotated.search_area(grid)
        rng = child(
            np.random.default_rng(self.searching.seed), "trial", key.description, target, key.start
        )
        posterior = self._posterior(target)
        inside = np.ones(grid.shape, dtype=bool) if area is None else area.cells
        belief = np.where(inside, 1 / inside.sum(), 0.0)
        questioner, observe = None, None
        if posterior is not None:
            belief = posterior.belief(target)
            tracker = BeliefTracker(posterior, {}, rng=rng)
            tracker.searched = (target,)
            observe = tracker.observe if posterior.is_coupled else _tracked(tracker)
            if key.questions:
                questioner = PosteriorQuestioner(
                    tracker, self._dialogue(key, posterior), least=_LEAST
                )
        episode = run_search(
            {target: np.maximum(belief, _LEAST)},
            self.city,
            {target: (place.x_m, place.y_m)},
            planner=self.searching.planner,
            config=self.searching.config(key.range_cells),
            rng=rng,
            start_area=None if area is None else area.cells,
            questioner=questioner,
            max_questions=key.questions,
            on_observation=observe if questioner is not None else None,
        )
        answered = [q for q in episode.questions if q.realised is not None]
        return replace(
            Trial.of(key, annotated, episode, time.perf_counter() - begun),
            asked=len(episode.questions),
            gross_reward=episode.gross_discounted_return,
            expected_bits=math.fsum(q.bits for q in answered),
            realised_bits=math.fsum(q.realised or 0.0 for q in answered),
            log_score=math.log(max(float(belief[place.cell]), 1e-300)),
        )

    def _posterior(self, target: str) -> Posterior | None:
        """Return what is believed of a target; None where nothing was read of it."""
        from sloop_ppl.inference import infer_description

        kept = self.recorded.get(target, ())[:1]
        name = target if kept else ""
        if name not in self._posteriors:
            kept_description = without(self.description, kept)
            area = self.annotated.search_area(self.city.grid)
            places = {t: (p.x_m, p.y_m) for t, p in self.annotated.targets.items()}
            self._posteriors[name] = None
            if kept_description.relations:
                with suppress(BeliefCollapse):  # searched with the uniform belief
                    self._posteriors[name], _ = infer_description(
                        kept_description, self.city, self.model, truth=places, area=area
                    )
        found = self._posteriors[name]
        return found if found is not None and target in found.targets else None

    def _dialogue(self, key: TrialKey, posterior: Posterior) -> Dialogue:
        from sloop_ppl.bridge.asking import Dialogue

        asking, target = self.asking, key.target
        rng = child(np.random.default_rng(self.searching.seed), "answers", key.description, target)
        place = self.annotated.targets[target]
        answerer: Any
        landmarks = None
        if asking.answerer == "a":
            answerer = OracleAnswerer(
                self.annotated, target, place.cell, error=asking.slips, guess=asking.guess, rng=rng
            )
        elif asking.answerer == "b":
            answerer = PersonAnswerer(
                self.annotated, target, self._person_place(target, rng), self.city,
                error=asking.slips, rng=rng,
            )  # fmt: skip
        else:
            answerer = RecordedAnswerer(self.recorded[target], self.description)
            landmarks = tuple(m for m in answerer.topics if m in self.city)
        return Dialogue(
            answerer,
            most=key.questions,
            cost=key.question_cost,
            steps=asking.steps,
            person=asking.person,
            kinds=asking.kinds,
            landmarks=landmarks,
            choose=_chooser(asking.choice, posterior, target, child(rng, "choice", key.start)),
        )

    def _person_place(self, target: str, rng: np.random.Generator) -> tuple[float, float]:
        """Return where the person thinks the target is."""
        place = self.annotated.targets[target]
        if child(rng, "shares the mistake").random() >= self.asking.rho:
            return place.x_m, place.y_m
        if target not in self._places:
            self._places[target] = speaker_place(self.annotated, target, self.city)
        return self._places[target]


def _tracked(tracker: Any) -> Callable[[Any], None]:
    """Return the hook that keeps what is seen for the next answer, and changes no belief."""

    def observe(likelihoods: Any) -> None:
        tracker.observe(likelihoods)

    return observe


def _chooser(
    choice: str, posterior: Posterior, target: str, rng: np.random.Generator
) -> Callable[[CandidateQuestions, NDArray[np.float64]], int | None] | None:
    """Return what chooses questions without weighing them."""
    if choice == "planned":
        return None
    if choice == "random":

        def any_of(candidates: CandidateQuestions, belief: NDArray[np.float64]) -> int | None:
            del belief
            return int(rng.integers(len(candidates))) if len(candidates) else None

        return any_of
    from sloop_ppl.bridge.relation_text import names_of

    names = names_of(posterior)
    grounds: Sequence[str] = [g for r in posterior.relations(target) for g in r.grounds]

    def side(candidates: CandidateQuestions, belief: NDArray[np.float64]) -> int | None:
        del belief
        for ground in grounds:
            start = f"On which side of {names.of(ground)} " if (
                ground in posterior.city) else None  # fmt: skip
            for k, text in enumerate(candidates.texts()):
                if start is not None and text.startswith(start):
                    return k
        return None

    return side


def recorded_of(
    annotated: AnnotatedDescription,
    others: Sequence[AnnotatedDescription],
    asking: AskingSettings,
    seed: int,
) -> Mapping[str, tuple[SpatialRelation, ...]]:
    """Return what was recorded beside a description, for answerer c; nothing for the others."""
    return recorded_relations(annotated, others, seed) if asking.answerer == "c" else {}
