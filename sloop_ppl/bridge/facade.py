"""The few functions most users need: parse, infer, search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sloop_ppl import language
from sloop_ppl.errors import InputError
from sloop_ppl.language import Description, TargetObject, Viewpoint, no_relation_found
from sloop_ppl.maps import CityMap, load_map

if TYPE_CHECKING:
    import numpy as np

    from sloop_ppl.inference import Engine, Posterior
    from sloop_ppl.models import ObservationModel

__all__ = ["infer", "parse"]


def parse(
    text: str,
    city: CityMap | str | Path,
    targets: Sequence[TargetObject] | None = None,
    parser: str = "rules",
    viewpoint: Viewpoint = "map",
    *,
    hearer: tuple[float, float] | None = None,
) -> Description:
    """Read what a text says about where targets are.

    Parameters
    ----------
    text
        English.
    city
        The map whose landmarks it speaks of, or its name or path as `load_map` takes it.
    targets
        The objects it may speak of; the default ones when None.
    parser
        Name of the parser.
    viewpoint
        ``"map"`` for who looks at a map, whose up is north; ``"ground"`` for who stands in the
        city. See :class:`sloop_ppl.language.Description`.
    hearer
        Where who listens is, x and y in metres, inside the map or outside: what "north of you"
        measures from.

    Returns
    -------
    Description
        Relations with the words they came from, and what was not understood.

    Raises
    ------
    UnknownName
        When there is no such parser, map or viewpoint.
    DescriptionError
        When `hearer` is not two finite numbers.

    Examples
    --------
    >>> said = parse("The red bike is behind Ivy.", "cleveland")
    >>> [(r.figure, r.relation, r.ground) for r in said.relations]
    [('RedBike', 'behind', 'Ivy')]
    """
    return language.parse(text, _city(city), targets, parser, viewpoint, hearer=hearer)


def infer(
    description: Description | str,
    city: CityMap | str | Path,
    model: str | ObservationModel = "bayes",
    engine: str | Engine = "exact",
    prior: Any = None,
    truth: Mapping[str, tuple[float, float]] | None = None,
    do: Mapping[str, Any] | None = None,
    rng: np.random.Generator | None = None,
    hearer: tuple[float, float] | None = None,
    area: Any = None,
) -> Posterior:
    """Infer where the targets of a description are.

    Parameters
    ----------
    description
        What was said, at least one relation; a text is read with `parse` first.
    city
        The map it was said of, or its name or path as `load_map` takes it.
    model
        Name of the observation model, or an ObservationModel.
    engine
        Name of the inference engine, or an engine with its options, such as
        ``sloop_ppl.inference.Importance(draws=1000)``.
    prior
        Belief before anything was said: None for uniform; a name of `sloop list priors`, or a
        ``.nc`` or ``.json`` file; an array (H, W) of weights; a function of the map and a target's
        id; or a mapping of target to one of these.
    truth
        Target -> true place in metres; only for the model ``informed``.
    do
        Interventions, such as ``{"frame": {"VelvetDog": 0.6}}`` (radians) or
        ``{"component": "product"}``.
    rng
        Wanted by engines that draw, ignored by exact ones.
    hearer
        Where who listens is, x and y in metres; that of the description when None.
    area
        Where the targets are searched for, and nowhere else: west, south, east and north border in
        metres; a shapely polygon; GeoJSON, as a mapping or the path of a file. The whole map when
        None. What a phrase means is measured over the map as before.

    Returns
    -------
    Posterior
        The belief over each target's cell; `.info` says how it was found.

    Raises
    ------
    NoRelationFound
        When the description says nothing about any target.
    UnknownName
        For an unknown model, engine, map or ground.
    InputError
        For a prior that is not one, a missing truth, an area that is none or off the map, or a
        description or map of another type.
    DescriptionError
        When a relation is to who listens, and `hearer` is not given or no place.
    BeliefCollapse
        When the prior excludes all that the description allows.

    Notes
    -----
    May be called from many threads: programs run one at a time, under
    ``sloop_ppl.inference.PYRO_LOCK``.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = sloop.parse("the green toyota is behind velvet dog", city)
    >>> sloop.infer(said, city, model="sloop").belief("GreenToyota").shape
    (41, 41)
    >>> sloop.infer("the red bike is near Ivy", "cleveland").targets
    ('RedBike',)
    """
    from sloop_ppl.inference import infer_description  # torch, which reading a text does without

    where = _city(city)
    utterance = description
    if isinstance(description, str):
        utterance = parse(description, where, hearer=hearer)
    if not isinstance(utterance, Description):
        raise InputError(
            f"What was said is a {type(utterance).__name__}; expected a text, or a Description as "
            "sloop_ppl.parse returns it"
        )
    if hearer is not None:
        utterance = replace(utterance, hearer=hearer)
    if not utterance.relations:
        raise no_relation_found(utterance, where)
    posterior, _ = infer_description(
        utterance, where, model, engine, prior=prior, truth=truth, do=do, rng=rng, area=area
    )
    return posterior


def _city(city: Any) -> CityMap:
    """Return a map, loaded when its name or path is given."""
    if isinstance(city, CityMap):
        return city
    if isinstance(city, str | Path):
        return load_map(city)
    raise InputError(
        f"The map is a {type(city).__name__}; expected a CityMap, the name of a bundled map or "
        "the path of a .geojson file"
    )
