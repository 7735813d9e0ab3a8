"""Infer from many descriptions of one map in one padded call of the Pyro program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.inference.exact import enumerated_log_factors
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, gather_evidence, ground_description, preset

__all__ = ["infer_batch"]

_MOST_NUMBERS = 60_000_000


def infer_batch(
    descriptions: Sequence[Description],
    city: CityMap,
    model: str | Preset = "bayes",
    *,
    prior: Any = None,
) -> tuple[dict[str, NDArray[np.float64]], ...]:
    """Return the beliefs that each description alone gives, by the exact engine.

    Parameters
    ----------
    descriptions : what was said, each on its own; all on this map.
    city : the map.
    model : a model's name, or a Preset.
    prior : the same belief before each; see :func:`sloop_ppl.inference.log_priors`.

    Returns
    -------
    tuple of dict
        For each description, target -> probability of each cell, shape (H, W), summing to one.

    Raises
    ------
    InputError : when the model has to be told the true places, or a map is another.
    BeliefCollapse : when the prior excludes all that a description allows.

    Notes
    -----
    Descriptions and targets are rows of one padded table, run through the program together; a
    table too large for memory is cut into several. Where phrases share frames, targets are
    coupled, and each description is inferred by itself.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = [sloop.parse(f"the red bike is near {name}", city) for name in ("Ivy", "Rumor")]
    >>> [list(beliefs) for beliefs in infer_batch(said, city)]
    [['RedBike'], ['RedBike']]
    """
    chosen = preset(model)
    if chosen.needs_truth:
        raise InputError(
            f"Model '{chosen.name}' needs to be told where the targets are; infer each description "
            "by itself"
        )
    if chosen.shared_frames:
        each = [infer_description(said, city, chosen, prior=prior)[0] for said in descriptions]
        return tuple({target: p.belief(target) for target in p.targets} for p in each)
    for said in descriptions:
        if said.map and said.map != city.name:
            raise InputError(f"A description was read on map '{said.map}'; expected '{city.name}'")
    grounded = [ground_description(said, city, chosen) for said in descriptions]
    rows = [terms for targets in grounded for terms in targets.values()]
    priors = [
        table for targets in grounded for table in log_priors(prior, tuple(targets), city).values()
    ]
    longest = max((len(terms) for terms in rows), default=1)
    size = len(chosen.components) * max(longest, 1) * city.grid.size
    step = max(1, _MOST_NUMBERS // size)
    found: list[NDArray[np.float64]] = []
    for start in range(0, len(rows), step):
        log_prior = torch.from_numpy(np.stack(priors[start : start + step]))
        with torch.no_grad():
            evidence = gather_evidence(rows[start : start + step], city, chosen)
        # One setting: nothing is shared. Sum over components.
        log_p = torch.logsumexp(enumerated_log_factors(evidence, log_prior)[:, 0], 1) + log_prior
        found += list(torch.softmax(log_p, -1).numpy().reshape(-1, *city.grid.shape))
    beliefs = iter(found)
    result = tuple({target: next(beliefs) for target in targets} for targets in grounded)
    _check(result, descriptions)
    return result


def _check(
    result: Sequence[dict[str, NDArray[np.float64]]], descriptions: Sequence[Description]
) -> None:
    for beliefs, said in zip(result, descriptions, strict=True):
        for target, belief in beliefs.items():
            if not np.isfinite(belief).all():
                raise BeliefCollapse(
                    f"What was said of '{target}' is impossible under the prior; expected some "
                    f"cell to remain: '{said.text}'; widen the prior",
                    observation=said,
                )
