"""Refit a model's parameters for each map on what was said of the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sloop_ppl.errors import InputError
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.inference.learning import Example, Fitted, fit
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import ObservationModel, unfitted

__all__ = ["examples_of", "refits", "refitted"]


def examples_of(
    descriptions: Sequence[AnnotatedDescription], find_map: Callable[[str], CityMap] = load_map
) -> list[Example]:
    """Return the gold relations of descriptions with the cells of their targets, to learn from.

    Lines without gold are left out.
    """
    examples = []
    for annotated in (one for one in descriptions if one.has_gold):
        city = find_map(annotated.map)
        places, area = annotated.places(city.grid), annotated.search_area(city.grid)
        cells = {target: place.cell for target, place in places.items()}
        examples.append(
            Example(
                annotated.description(city),
                city,
                cells,
                annotated.speaker,
                None if area is None else area.cells,
            )
        )
    return examples


def refitted(
    descriptions: Sequence[AnnotatedDescription],
    model: ObservationModel,
    find_map: Callable[[str], CityMap] = load_map,
    *,
    iterations: int = 30,
    progress: Callable[[str], None] | None = None,
) -> dict[str, ObservationModel]:
    """Return map name -> the model fitted to the descriptions of all other cities.

    Parameters
    ----------
    descriptions
        Scenes of at least two cities; see :class:`AnnotatedDescription` for what a city is.
    model
        Where the fit starts; `bayes` starts from where it stood before its own fit, which has seen
        all maps.
    find_map
        Gives the map of a description by name.
    iterations
        At most this many of L-BFGS per fit.
    progress
        Called with a line at a time on how it goes.

    Raises
    ------
    InputError
        When all descriptions are of one city.
    """
    found = refits(descriptions, model, find_map, iterations=iterations, progress=progress)
    start = unfitted(model)
    return {left_out: fitted.apply(start) for left_out, fitted in found.items()}


def refits(
    descriptions: Sequence[AnnotatedDescription],
    model: ObservationModel,
    find_map: Callable[[str], CityMap] = load_map,
    *,
    iterations: int = 30,
    progress: Callable[[str], None] | None = None,
) -> dict[str, Fitted]:
    """Return map name -> the numbers fitted to the descriptions of all other cities.

    They belong to ``unfitted(model)``; parameters and errors are those of `refitted`.
    """
    maps: dict[str, set[str]] = {}
    for annotated in descriptions:
        maps.setdefault(annotated.city, set()).add(annotated.map)
    if len(maps) < 2:
        raise InputError(
            f"The descriptions are of one map ({', '.join(maps)}); expected at least two, so that "
            "one can be left out"
        )
    start = unfitted(model)
    found: dict[str, Fitted] = {}
    for left_out, own in maps.items():
        rest = examples_of(
            [annotated for annotated in descriptions if annotated.city != left_out], find_map
        )
        fitted = fit(rest, start, iterations=iterations, intervals=False)
        found |= dict.fromkeys(sorted(own), fitted)
        if progress:
            score = fitted.provenance["mean_log_score_after"]
            progress(f"{model.name} without {left_out}: mean log score {score:.3f} on the rest")
    return found
