"""An episode that keeps the posterior, so that it can be updated and go on."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge._timed_utterances import follow_up
from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior
from sloop_ppl.language import Description
from sloop_ppl.planning.environment import Report
from sloop_ppl.planning.episode import Episode

if TYPE_CHECKING:
    from sloop_ppl.planning import Step

__all__ = ["OneLeg", "PosteriorEpisode", "SearchSetup", "after", "joined"]

Table = NDArray[np.float64]


@dataclass(frozen=True)
class SearchSetup:
    """What a search runs with beside its settings; see `sloop_ppl.planning.run_search`.

    Parameters
    ----------
    planner
        A planner or its name.
    sensor, motion, environment
        Those that are not the settings' own.
    search_legs
        What searches on, for `PosteriorEpisode.go_on`.
    dialogue
        Who can be asked; nobody when None.
    """

    planner: Any
    sensor: Any = None
    motion: Any = None
    environment: Any = None
    search_legs: Callable[..., PosteriorEpisode] | None = None
    dialogue: Any = None


class OneLeg:
    """An environment in a search for some of the targets: it is not heard of the others.

    Parameters
    ----------
    environment
        The environment; one that is none is refused by the search.
    others
        Targets that are not searched for at present.
    """

    def __init__(self, environment: Any, others: Collection[str]) -> None:
        self._environment, self._others = environment, others

    @property
    def pose(self) -> Any:
        """Where the robot is."""
        return self._environment.pose

    def execute(self, action: Any) -> Any:
        """Carry out an action and return what came of it, without the other targets."""
        outcome = self._environment.execute(action)
        try:
            pose, report, collision = outcome
        except (TypeError, ValueError):
            return outcome
        if isinstance(report, Mapping):
            report = Report(report)
        if isinstance(report, Report):
            seen = {t: at for t, at in report.seen.items() if t not in self._others}
            report = Report(seen, tuple(t for t in report.found if t not in self._others))
        return pose, report, collision


@dataclass(frozen=True, eq=False)
class PosteriorEpisode(Episode):
    """A search with what is believed after it; see `Episode` for the rest.

    Parameters
    ----------
    posterior
        The joint posterior after all that was seen and said.
    utterances
        Steps taken -> description given then.
    pending_steps
        Steps whose utterances were never given, for the search had ended.
    setup
        Planner, sensor, motion and environment, by which `go_on` goes on.
    """

    posterior: Posterior | None = None
    utterances: Mapping[int, Description] = field(default_factory=lambda: MappingProxyType({}))
    pending_steps: tuple[int, ...] = ()
    setup: SearchSetup | None = field(default=None, repr=False)

    def update(
        self, description: Description | str, rng: np.random.Generator | None = None
    ) -> PosteriorEpisode:
        """Return the episode with the posterior after one more description.

        Parameters
        ----------
        description
            What is said now; a text is read in the light of what was said before.
        rng
            Wanted by engines that draw.

        Raises
        ------
        NoRelationFound
            When it speaks of no target.
        BeliefCollapse
            When it excludes all that is believed after the search.
        """
        posterior = self._posterior()
        if isinstance(description, str):
            description = follow_up(posterior, description)
        utterances = {**self.utterances, self.steps: description}
        return replace(
            self,
            posterior=posterior.update(description, rng=rng),
            utterances=MappingProxyType(utterances),
        )

    def go_on(self, max_steps: int | None = None, *, rng: np.random.Generator) -> PosteriorEpisode:
        """Search on for what was not found, from the last pose and with the present posterior.

        Parameters
        ----------
        max_steps
            How many steps more; as many as the settings allow a search when None.
        rng
            Where environment and planner draw from.

        Returns
        -------
        PosteriorEpisode
            The whole, from the first step on; itself when all is found.
        """
        left = tuple(t for t in self.targets or self.places if t not in self.found_targets)
        if not left:
            return self
        config, setup = self.config, self.setup
        if setup is None or setup.search_legs is None:
            raise InputError("This episode does not know how it was searched; use sloop_ppl.search")
        more = setup.search_legs(
            self._posterior(),
            self.places,
            (left,),
            setup=setup,
            config=config if max_steps is None else replace(config, max_steps=max_steps),
            start=self.poses[-1] if setup.environment is None else None,
            rng=rng,
            keep_beliefs=bool(self.beliefs),
        )
        whole = joined(self, replace(more, config=config))
        return replace(
            whole, imagined=self.imagined, utterances=self.utterances, posterior=more.posterior
        )

    def _posterior(self) -> Posterior:
        if self.posterior is None:
            raise InputError("This episode keeps no posterior; search with sloop_ppl.search")
        return self.posterior


def joined(first: PosteriorEpisode, second: PosteriorEpisode) -> PosteriorEpisode:
    """Return two searches, the second of which began where the first ended, as one."""
    places = {**first.places, **{t: p for t, p in second.places.items() if t not in first.places}}
    targets = (*first.targets, *(t for t in second.targets if t not in first.targets))
    found = {*first.found_targets, *second.found_targets}
    return replace(
        second,
        places=MappingProxyType(places),
        targets=targets,
        notes=(*first.notes, *(n for n in second.notes if n not in first.notes)),
        poses=first.poses + second.poses[1:],
        actions=first.actions + second.actions,
        observations=tuple(
            MappingProxyType({t: seen.get(t) for t in targets})
            for seen in (*first.observations, *second.observations)
        ),
        rewards=first.rewards + second.rewards,
        found_targets=tuple(t for t in targets if t in found),
        views=np.concatenate([first.views, second.views[1:]]),
        info=first.info + second.info,
        beliefs=first.beliefs + second.beliefs[1:],
        questions=first.questions
        + tuple(replace(q, step=first.steps + q.step) for q in second.questions),
    )


def after(step: Step, before: PosteriorEpisode | None, others: Mapping[str, Table]) -> Step:
    """Return a step of a later leg as a step of the whole search."""
    if before is None:
        return step
    return replace(
        step,
        index=before.steps + step.index,
        found_targets=before.found_targets + step.found_targets,
        beliefs=MappingProxyType({**others, **step.beliefs}),
    )
