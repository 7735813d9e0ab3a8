"""Follow a search with the joint posterior: what is seen and what is said, in any order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse
from sloop_ppl.inference import AnswerFactor, Posterior
from sloop_ppl.language import Description
from sloop_ppl.rng import child

__all__ = ["BeliefTracker"]

Tables = Mapping[str, NDArray[np.float64]]


class BeliefTracker:
    """The joint posterior during a search, as the hook `on_observation` of ``run_search``.

    Parameters
    ----------
    utterances
        Steps taken -> what is said then.
    recovery_weight
        Share of the beliefs at the start that is mixed in when an observation is impossible; with 0
        it raises `BeliefCollapse`.

    Notes
    -----
    Targets that share no frame are left to the search's own update, which is the same
    sum; the posterior then catches up when it is asked for.
    """

    def __init__(
        self,
        posterior: Posterior,
        utterances: Mapping[int, Description],
        *,
        recovery_weight: float = 0.0,
        rng: np.random.Generator,
    ) -> None:
        self._posterior, self._utterances, self._rng = posterior, dict(utterances), rng
        self._weight = recovery_weight
        self._initial = {t: posterior.belief(t) for t in posterior.targets if recovery_weight}
        self._sensed: dict[str, NDArray[np.float64]] = {}
        self._coupled = posterior.is_coupled
        self._steps = 0
        self.searched = posterior.targets

    @property
    def posterior(self) -> Posterior:
        """The posterior after all that was seen and said so far."""
        self._catch_up()
        return self._posterior

    @property
    def language(self) -> Posterior:
        """The posterior after all that was said and answered, perhaps without the last looks."""
        return self._posterior

    @property
    def pending_steps(self) -> tuple[int, ...]:
        """The steps for which there are words but that have not been reached."""
        return tuple(sorted(step for step in self._utterances if step > self._steps))

    def observe(self, log_factors: Tables) -> Tables | None:
        """Take what a step showed and return the beliefs it changes beyond the search's own.

        Parameters
        ----------
        log_factors
            Target -> log likelihood of each cell, shape (H, W).

        Returns
        -------
        dict or None
            Beliefs of the searched targets; None when nothing was said and no frame is shared.
        """
        self._steps += 1
        for target, table in log_factors.items():
            # Log likelihoods add up: what is seen is independent given where the target is.
            self._sensed[target] = self._sensed.get(target, 0.0) + table
        utterance = self._utterances.get(self._steps)
        # Recovery asks of each step whether it is impossible, so it cannot be put off.
        if self._weight:
            self._catch_up()
        if utterance is not None:
            self.update(utterance)
        elif not self._coupled:
            return None
        self._catch_up()
        return {target: self._posterior.belief(target) for target in self.searched}

    def update(self, description: Description | AnswerFactor) -> None:
        """Take what is said or answered."""
        self._catch_up()
        rng = child(self._rng, "said", self._steps)
        self._posterior = self._posterior.update(description, rng=rng)
        self._coupled = self._posterior.is_coupled

    def _catch_up(self) -> None:
        if not self._sensed:
            return
        sensed, self._sensed = self._sensed, {}
        try:
            self._posterior = self._posterior.condition(sensed)
        except BeliefCollapse:
            if not self._weight:
                raise
            self._posterior = self._recovered(sensed)

    def _recovered(self, sensed: Tables) -> Posterior:
        """Return the beliefs, with those mixed in that were held at the start, as a new prior."""
        tables = {}
        for target in self._posterior.targets:
            before = self._posterior.belief(target)
            likelihood = np.exp(sensed.get(target, np.zeros_like(before)))
            after = before * likelihood
            if not after.any():
                # As GridBelief does in the search itself.
                mixed = (1 - self._weight) * before + self._weight * self._initial[target]
                after = mixed * likelihood
            if not after.any():
                raise BeliefCollapse(
                    f"What was seen of '{target}' is impossible even under the belief at the "
                    "start; give a belief that is nowhere zero",
                    prior=before,
                    observation=sensed,
                )
            tables[target] = after.reshape(-1) / after.sum()
        with np.errstate(divide="ignore"):
            log_prior = {target: np.log(table) for target, table in tables.items()}
        return replace(
            self._posterior,
            log_prior=log_prior,
            factors=(),
            answers=(),
            log_sensed={target: np.zeros_like(table) for target, table in tables.items()},
        )
