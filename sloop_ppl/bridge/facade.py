"""The few functions most users need: parse, infer, search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sloop_ppl import language
from sloop_ppl.inference import Posterior, infer_description
from sloop_ppl.language import Description, TargetObject, no_relation_found
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset

__all__ = ["infer", "parse"]


def parse(
    text: str,
    city: CityMap,
    targets: Sequence[TargetObject] | None = None,
    parser: str = "rules",
) -> Description:
    """Read what a text says about where targets are.

    Parameters
    ----------
    text : English.
    city : the map whose landmarks it speaks of.
    targets : the objects it may speak of; the default ones when None.
    parser : name of the parser.

    Returns
    -------
    Description
        Relations with the words they came from, and what was not understood.

    Raises
    ------
    UnknownName : when there is no such parser.
    """
    return language.parse(text, city, targets=targets, parser=parser)


def infer(
    description: Description,
    city: CityMap,
    model: str | Preset = "bayes",
    engine: str = "exact",
    prior: Any = None,
    truth: Mapping[str, tuple[float, float]] | None = None,
    do: Mapping[str, Any] | None = None,
    rng: np.random.Generator | None = None,
) -> Posterior:
    """Infer where the targets of a description are.

    Parameters
    ----------
    description : what was said; at least one relation.
    city : the map it was said of.
    model : name of the observation model, or a Preset.
    engine : name of the inference engine.
    prior : belief before anything was said: None for uniform; a name of `sloop list priors`, or
        a ``.nc`` or ``.json`` file; an array (H, W) of weights; a function of the map and a
        target's id; or a mapping of target to one of these.
    truth : target -> true place in metres; only for the model ``informed``.
    do : interventions, such as ``{"frame": {"VelvetDog": 0.6}}`` (radians) or
        ``{"component": "product"}``.
    rng : wanted by engines that draw, ignored by exact ones.

    Returns
    -------
    Posterior
        The belief over each target's cell; `.info` says how it was found.

    Raises
    ------
    NoRelationFound : when the description says nothing about any target.
    UnknownName : for an unknown model, engine or ground.
    InputError : for a prior that is not one, or a missing truth.
    BeliefCollapse : when the prior excludes all that the description allows.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = sloop.parse("the green toyota is behind velvet dog", city)
    >>> sloop.infer(said, city, model="sloop").belief("GreenToyota").shape
    (41, 41)
    """
    if not description.relations:
        raise no_relation_found(description, city)
    posterior, _ = infer_description(
        description, city, model, engine, prior=prior, truth=truth, do=do, rng=rng
    )
    return posterior
