"""Questions about where a target is: which side, nearer to what, inside, which street, how far.

Shape legend: S cells of the scene.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge.asking.kinds import Proposal
from sloop_ppl.bridge.asking.scene import Scene
from sloop_ppl.maps import PATH_KINDS

__all__ = ["distances", "inside", "nearer", "sides", "streets"]

Table = NDArray[np.float64]

_SIDES = ("north", "east", "south", "west")
_NEAR_PAIRS = 10
_MOST_STREETS, _NAMED_STREETS = 4, 8
_LEAST_CELLS = 4
_SAME_M = 10.0
_LEAST_SHARE = 0.02


def _places(scene: Scene) -> list[str]:
    """Return the landmarks that are no ways: a long street has sides, but not four."""
    return [m for m in scene.landmarks if scene.city.landmark(m).kind not in PATH_KINDS]


def sides(scene: Scene) -> Iterator[Proposal]:
    """Yield "on which side of X": the quarter around north, east, south or west of its centroid."""
    for landmark in _places(scene):

        def table(at: Scene, landmark: str = landmark) -> Table:
            return at.quarters(landmark)

        yield Proposal(
            f"On which side of {scene.label(landmark)} {scene.subject}: north, east, south or "
            "west?",
            _SIDES,
            table,
            (landmark,),
        )


def nearer(scene: Scene) -> Iterator[Proposal]:
    """Yield "nearer to A or to B", of the landmarks nearest to the belief."""
    for one, other in itertools.combinations(_places(scene)[:_NEAR_PAIRS], 2):

        def table(at: Scene, one: str = one, other: str = other) -> Table:
            second = at.nearer_to_other(one, other)
            return np.stack([1.0 - second, second])

        def same(at: Scene, one: str = one, other: str = other) -> Table:
            return np.exp(-np.abs(at.distance_m(one) - at.distance_m(other)) / _SAME_M)

        first, second = scene.label(one), scene.label(other)
        if first.casefold() != second.casefold():
            yield Proposal(
                f"{scene.subject[:1].upper()}{scene.subject[1:]} nearer to {first} or to {second}?",
                (first, second),
                table,
                (one, other),
                others={"neither": same, "both": same, "about the same": same},
            )


def inside(scene: Scene) -> Iterator[Proposal]:
    """Yield "inside X or outside it", of those that cover a few cells."""
    for landmark in _places(scene):
        if int(scene.city.cells(landmark).sum()) < _LEAST_CELLS:
            continue

        def table(at: Scene, landmark: str = landmark) -> Table:
            covered = at.covered(landmark)
            return np.stack([covered, 1.0 - covered])

        yield Proposal(
            f"{scene.subject[:1].upper()}{scene.subject[1:]} inside {scene.label(landmark)} or "
            "outside it?",
            ("inside", "outside"),
            table,
            (landmark,),
        )


def streets(scene: Scene) -> Iterator[Proposal]:
    """Yield "which street": the nearest named one; those that are improbable are "another"."""
    city = scene.city
    x, y = scene.posterior.expected(scene.target)
    named = [m for m in city.of_kind("street", "pedestrian") if m.name]
    near = [m.id for m, _ in _by_distance(scene, named, x, y)[:_NAMED_STREETS]]
    labels: dict[str, list[str]] = {}
    for street in near:  # parts of one street have one name
        labels.setdefault(scene.label(street), []).append(street)
    if len(labels) < 2:
        return
    nearest = np.argmin(_apart(scene, list(labels.values())), axis=0)
    masses = np.bincount(nearest, weights=scene.belief(), minlength=len(labels)).astype(np.float64)
    mass = masses / max(float(masses.sum()), 1e-300)
    order = [k for k in np.argsort(-mass, kind="stable") if mass[k] >= _LEAST_SHARE]
    kept = [int(k) for k in order[:_MOST_STREETS]]
    if len(kept) < 2:
        return
    names = list(labels)
    groups = list(labels.values())
    rest = len(kept) < len(names)

    def table(at: Scene) -> Table:
        found = at.person.nearest(_apart(at, groups))
        others = [k for k in range(len(names)) if k not in kept]
        return np.concatenate([found[kept], found[others].sum(0, keepdims=True)][: 1 + rest])

    options = tuple(names[k] for k in kept)
    listed = ", ".join(options) if rest else f"{', '.join(options[:-1])} or {options[-1]}"
    yield Proposal(
        f"Which street {scene.subject} on, or nearest to: {listed}"
        f"{' or another one' if rest else ''}?",
        options + (("another one",) if rest else ()),
        table,
        tuple(labels[names[k]][0] for k in kept),
    )


def _by_distance(scene: Scene, among: list, x: float, y: float) -> list:  # type: ignore[type-arg]
    found = [(m, scene.city.nearest(x, y, [m])) for m in among]
    return sorted(((m, near[1]) for m, near in found if near is not None), key=lambda pair: pair[1])


def _apart(scene: Scene, groups: list[list[str]]) -> Table:
    """Return logarithms of metres from each cell to the parts of G streets, shape (G, S)."""
    metres = np.stack([np.min([scene.distance_m(m) for m in group], axis=0) for group in groups])
    found: Table = np.log(np.maximum(metres, scene.city.grid.cell_m / 2))
    return found


def distances(scene: Scene) -> Iterator[Proposal]:
    """Yield "how far from X": three ranges that are about as probable as each other."""
    belief = scene.belief()
    total = max(float(belief.sum()), 1e-300)
    for landmark in _places(scene):
        apart = scene.distance_m(landmark)
        order = np.argsort(apart, kind="stable")
        running = np.cumsum(belief[order]) / total
        at = [float(apart[order[np.searchsorted(running, q)]]) for q in (1 / 3, 2 / 3)]
        low, high = (max(5, 5 * round(metres / 5)) for metres in at)
        if low == high:
            continue

        def table(
            there: Scene, landmark: str = landmark, low: float = low, high: float = high
        ) -> Table:
            above = [there.farther(landmark, metres) for metres in (low, high)]
            return np.stack([1.0 - above[0], above[0] - above[1], above[1]])

        yield Proposal(
            f"How far {scene.subject} from {scene.label(landmark)}: up to {low} m, {low} to {high} "
            "m, or farther?",
            (f"up to {low} m", f"{low} to {high} m", "farther"),
            table,
            (landmark,),
        )
