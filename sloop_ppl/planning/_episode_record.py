"""The format of a saved episode, checked before memory is taken for it.

Shape legend: H, W grid.
"""

from __future__ import annotations

from typing import Annotated, Any

from msgspec import Meta, Struct

__all__ = ["EpisodeRecord", "InfoRecord", "QuestionRecord", "check_counts"]

_MOST_VIEWED = 2**31
"""Cells of all views together: a byte each."""

# The bounds exclude nan and inf.
Number = Annotated[float, Meta(ge=-1e300, le=1e300, description="a finite number")]
Weight = Annotated[float, Meta(ge=0, le=1e300, description="a finite number of at least 0")]
Count = Annotated[int, Meta(ge=0, le=2**53, description="a number of at least 0")]
Side = Annotated[int, Meta(ge=1, le=100_000, description="a number from 1 to 100000")]
Pair = Annotated[tuple[Number, Number], Meta(description="two numbers")]
Pose = Annotated[tuple[Number, Number, Number], Meta(description="three finite numbers")]
Names = Annotated[list[str], Meta(description="a list of texts")]
Shares = dict[str, Number]


class InfoRecord(Struct):
    """What a planner said about one decision."""

    planner: str
    sims: Count
    values: Shares
    visits: dict[str, Count]
    expected: dict[str, Shares]
    notes: dict[str, Any]


class QuestionRecord(Struct):
    """A question that was asked."""

    step: Count
    text: str
    answer: str | None
    target: str = ""
    cost: Weight = 0.0
    steps: Count = 0
    bits: Weight = 0.0
    realised_bits: Number | None = None
    gain: Number | None = None
    note: str = ""


class EpisodeRecord(Struct):
    """An episode as `write_episode` writes it; other members are passed over."""

    map: str
    planner: str
    config: Annotated[dict[str, Any], Meta(description="an object of settings")]
    shape: Annotated[tuple[Side, Side], Meta(description="two numbers from 1 to 100000")]
    places: Annotated[dict[str, Pair], Meta(description="an object of places")]
    poses: Annotated[list[Pose], Meta(description="a list of poses")]
    actions: Names
    observations: Annotated[list[dict[str, Any]], Meta(description="a list of objects")]
    rewards: Annotated[list[Number], Meta(description="a list of numbers")]
    found_targets: Names
    views: Annotated[list[list[Count]], Meta(description="a list of lists of cells")]
    info: Annotated[list[InfoRecord], Meta(description="a list of objects")]
    beliefs: Annotated[
        list[dict[str, list[list[Weight]]]], Meta(description="a list of tables by target")
    ]
    imagined: Names = []
    map_digest: str = ""
    targets: Names = []
    notes: Names = []
    questions: Annotated[list[QuestionRecord], Meta(description="a list of objects")] = []


def check_counts(record: EpisodeRecord) -> None:
    """Raise `ValueError` when the parts of an episode do not fit each other or its map."""
    n, (height, width) = len(record.actions), record.shape
    expected = {"poses": n + 1, "views": n + 1, "rewards": n, "observations": n}
    for name, count in expected.items():
        found = len(getattr(record, name))
        if found != count:
            raise ValueError(f"{n} actions and {found} {name}; expected {count}")
    for name, most in (("info", n), ("beliefs", n + 1)):  # beliefs: those that were kept
        if len(getattr(record, name)) > most:
            raise ValueError(f"{n} actions and {len(getattr(record, name))} of '{name}'")
    if (n + 1) * height * width > _MOST_VIEWED:
        raise ValueError(
            f"{n + 1} views of {height} x {width} cells; expected at most {_MOST_VIEWED} in all"
        )
    cells = [cell for view in record.views for cell in view]
    if max(cells, default=0) >= height * width:
        raise ValueError(f"cell {max(cells)} is in view; the map has {height * width}")
    known = set(record.targets or record.places)
    if not set(record.found_targets) <= known:
        raise ValueError(f"found are {', '.join(record.found_targets)}; not all were searched for")
    for tables in record.beliefs:
        for name, rows in tables.items():
            if len(rows) != height or any(len(row) != width for row in rows):
                raise ValueError(f"the belief of {name} has not {height} x {width} cells")
