"""What a page asks for, as records: the state that a link holds, and requests about it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from sloop_ppl.web import _limits

__all__ = ["Evidence", "Metres", "Name", "Place", "SearchAsked", "State", "WhyAsked"]

Metres = Annotated[float, Meta(ge=-1e6, le=1e6, description="metres")]
Name = Annotated[str, Meta(max_length=200, description="a name")]
Words = Annotated[str, Meta(max_length=_limits.MOST_TEXT, description="a text")]
Place = tuple[Metres, Metres]
Corners = Annotated[
    tuple[Place, ...],
    Meta(min_length=3, max_length=_limits.MOST_CORNERS, description="a list of 3 to 200 corners"),
]


class Evidence(Struct, frozen=True, forbid_unknown_fields=True):
    """Someone looked at a place: the target is there, or it is not.

    Parameters
    ----------
    target
        Id of the target.
    at
        x and y, metres.
    radius_m
        How far from there was looked.
    is_there
        Whether it was seen.
    """

    target: Name
    at: Place
    radius_m: Annotated[float, Meta(gt=0, le=1000, description="metres, up to 1000")] = 10.0
    is_there: bool = False


class State(Struct, frozen=True, forbid_unknown_fields=True):
    """Map, words, model and evidence: all that a belief follows from.

    Parameters
    ----------
    map
        Name of a bundled map, or digest of another.
    text
        What was said.
    model, variant, frames, prior
        Names; `frames` and `prior` are the model's own where None.
    viewpoint
        ``map`` or ``ground``.
    off
        Phrases that are left out, by their position among the relations that were read.
    evidence
        What was looked at, in order.
    area
        West, south, east and north border of the area searched, metres.
    answers
        Questions that were asked, with the answer to each.
    polygon
        Corners of the area searched, where it is no rectangle; it counts instead of `area`.
    parameters
        Section -> name -> value: the numbers of the model that were changed; see
        :func:`sloop_ppl.models.with_parameters`.
    """

    map: Name
    text: Words
    model: Name = "bayes"
    variant: Name = "published"
    frames: Name | None = None
    prior: Name | None = None
    viewpoint: Name = "map"
    off: Annotated[tuple[int, ...], Meta(max_length=64, description="a list of numbers")] = ()
    evidence: Annotated[tuple[Evidence, ...], Meta(max_length=100, description="a list")] = ()
    area: tuple[Metres, Metres, Metres, Metres] | None = None
    answers: Annotated[
        tuple[tuple[Words, Words], ...], Meta(max_length=10, description="a list of pairs")
    ] = ()
    polygon: Corners | None = None
    parameters: dict[
        Name, Annotated[dict[Name, bool | float], Meta(max_length=64, description="an object")]
    ] = {}


class WhyAsked(Struct, frozen=True, forbid_unknown_fields=True):
    """Why a target's belief is what it is, at a place if one is given."""

    state: State
    target: Name
    at: Place | None = None


class SearchAsked(Struct, frozen=True, forbid_unknown_fields=True):
    """A search for the targets of a belief.

    Parameters
    ----------
    state
        What the belief follows from.
    planner
        Name of a planner.
    places
        Target -> true place, metres; one not given is drawn.
    start
        Where the drone starts, metres; drawn when None.
    seed
        Seed of all that is drawn.
    sims, steps, range_cells
        Simulations a step, steps at most, reach of the sensor.
    utterances
        Pairs of steps taken and what is said then.
    """

    state: State
    planner: Name = "fast"
    places: dict[Name, Place] = {}
    start: Place | None = None
    seed: Annotated[int, Meta(ge=0, le=2**31, description="a whole number")] = 0
    sims: Annotated[int, Meta(ge=1, le=_limits.MOST_SIMS, description="a number")] = 1000
    steps: Annotated[int, Meta(ge=1, le=_limits.MOST_STEPS, description="a number")] = 200
    range_cells: Annotated[float, Meta(ge=1, le=30, description="cells, 1 to 30")] = 3.0
    utterances: Annotated[
        tuple[tuple[Annotated[int, Meta(ge=0, le=_limits.MOST_STEPS)], Words], ...],
        Meta(max_length=20, description="a list of steps with texts"),
    ] = ()
