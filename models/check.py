"""Try a likelihood out and say what is wrong with it, in the manner of Gymnasium's check_env."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.language import SPEAKER, SpatialRelation, words_by_class
from sloop_ppl.maps import CityMap, Grid, Landmark
from sloop_ppl.models.frames import FrameDistribution, FramePart
from sloop_ppl.models.grounded_relation import GroundedRelation, ground_relations
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.likelihoods import (
    ClosedFormMarginal,
    RelationLikelihood,
    parameters_of,
    with_values,
)

__all__ = ["check_likelihood", "check_table"]

_SIDE, _CELL_M = 24, 5.0  # a map of 120 m: small, and all words are true somewhere on it
_BLOCK_M = 10.0
_MOST_MOVED = 0.25  # a ground's own cells, and with them its edge, move by up to half a cell
_ANGLES = (0.3, 1.2, -2.0, 3.0, -0.9)  # in no order, none a multiple of another or of 45 degrees
_QUADRATURE = 2880  # twice the directions of `marginal_over`, so that one does not hide the other
_SOME = np.array([0, 311, 100, 100, 575])  # in no order, one twice
_JUMP = 0.02  # change of g in one step; a von Mises shape has .0013 sqrt(kappa) at most
_FORMS = {"point": "a point", "line": "a line", "area": "an area"}
_FRAMES = {
    "a point": FrameDistribution((FramePart(0.7, math.inf),)),
    "a von Mises part of kappa 40": FrameDistribution((FramePart(0.7, 40.0),)),
    "a wide part with lapse": FrameDistribution((FramePart(-2.0, 1.5, 0.8),), lapse=0.2),
    "lapse alone": FrameDistribution((), lapse=1.0),
}


def check_likelihood(likelihood: RelationLikelihood, skip: Sequence[str] = ()) -> None:
    """Try a likelihood on a small map and raise on the first promise it breaks.

    Checked are, for every class of relation and a house, a street and a point as ground: shape,
    dtype, finiteness and sign of log g; that some cells alone have the values they have among all;
    that directions broadcast; gradients in the declared parameters; that turning or mirroring the
    map turns or mirrors g; that halving the cells keeps it; and, if it has ``log_marginal``, that
    it agrees with quadrature.

    Parameters
    ----------
    likelihood
        Anything with ``log_g(term, direction_rad)``; a latent that it declares is tried at the
        first of its values.
    skip
        Promises it does not make: ``"tables"``, ``"gradients"``, ``"rotation"``, ``"cells"`` or
        ``"marginal"``. One that is absolute by intention, such as one seen from where a speaker
        stands, does not turn with the map: ``skip=("rotation",)``.

    Raises
    ------
    UnknownName
        For a promise there is none of.
    InputError
        On the first fault; it names the relation, what was found and what was expected.

    Examples
    --------
    >>> from sloop_ppl.models import LIKELIHOODS
    >>> check_likelihood(LIKELIHOODS["student-vonmises"])
    """
    name = _name(likelihood)
    if not callable(getattr(likelihood, "log_g", None)):
        raise InputError(f"{name} has no method log_g(term, direction_rad); a likelihood needs one")
    for promise in skip:
        if promise not in _PROMISES:
            raise UnknownName("promise of a likelihood", promise, _PROMISES)
    for promise, check in _PROMISES.items():
        if promise not in skip:
            check(likelihood)


def check_table(log_g: object, expected: tuple[int, ...], what: str) -> Tensor:
    """Return what a likelihood gave if it is a table of log probabilities.

    Parameters
    ----------
    log_g
        What was returned.
    expected
        Its shape: (B directions, S cells) or (S cells,).
    what
        Whose it is, for the message.

    Raises
    ------
    InputError
        For another type, dtype or shape, NaN, infinity, or a positive log.
    """
    if not isinstance(log_g, Tensor):
        raise InputError(f"{what} is a {type(log_g).__name__}; expected a torch.Tensor")
    if tuple(log_g.shape) != expected:
        dims = "(B directions, S cells)" if len(expected) == 2 else "(S cells,)"
        raise InputError(
            f"{what} has shape {tuple(log_g.shape)}; expected {expected}, that is {dims}"
        )
    if log_g.dtype != torch.float64:
        raise InputError(f"{what} has dtype {log_g.dtype}; expected torch.float64")
    finite = torch.isfinite(log_g)
    if not bool(finite.all()):
        bad = log_g[~finite][0].item()
        raise InputError(
            f"{what} is {bad} at {int((~finite).sum())} of {log_g.numel()} places; expected finite "
            "logs: give g a small floor"
        )
    most = float(log_g.detach().max())
    if most > 1e-9:
        raise InputError(
            f"{what} is {most:.3g} at its highest; expected at most 0: g is a probability"
        )
    return log_g


@dataclass(frozen=True)
class _Case:
    """One relation on the test map."""

    term: GroundedRelation
    directions: Tensor | None

    @property
    def label(self) -> str:
        return f"relation '{self.term.relation}' of {_FORMS[self.term.form]}"

    def table(self, likelihood: RelationLikelihood) -> Tensor:
        """Return log g, checked."""
        return self._table(likelihood, self.term, self.label)

    def table_at(self, likelihood: RelationLikelihood, cells: NDArray[np.intp]) -> Tensor:
        """Return log g at some cells, checked."""
        label = f"{self.label} at {len(cells)} of its cells (GroundedRelation.at)"
        return self._table(likelihood, self.term.at(cells), label)

    def _table(self, likelihood: RelationLikelihood, term: GroundedRelation, label: str) -> Tensor:
        cells = (term.n_cells,)
        expected = cells if self.directions is None else (len(self.directions), *cells)
        what = f"log_g of {_name(likelihood)} for {label}"
        return check_table(likelihood.log_g(term, self.directions), expected, what)


Move = Callable[[float, float], tuple[float, float]]


def _city(cell_m: float = _CELL_M, move: Move = lambda x, y: (x, y)) -> CityMap:
    """Return the test map, its landmarks moved."""
    half, slack = _SIDE * _CELL_M / 2, 0.01
    shapes = {
        ("House", "building"): shapely.box(7.1, -12.9, 21.3, -4.2),
        ("MainSt", "street"): shapely.LineString([(-60, 31.2), (60, 31.2)]),
        ("Pole", "poi"): shapely.Point(-17.4, 3.3),
    }

    def moved(points: object) -> object:
        return torch.tensor([move(x, y) for x, y in points]).numpy()  # type: ignore[attr-defined]

    return CityMap(
        "check",
        Grid(-half, -half + slack, half - slack, half, cell_m),
        tuple(
            Landmark(name, kind, shapely.transform(shape, moved), width_m=4.0)
            for (name, kind), shape in shapes.items()
        ),
    )


def _cases(
    likelihood: RelationLikelihood, city: CityMap, turn: Callable[[float], float] = lambda a: a
) -> Iterator[_Case]:
    """Yield one relation of each class for each ground, its directions turned.

    An object is the figure, and who speaks, whose own place a likelihood may read otherwise.
    """
    latents: tuple[Latent, ...] = tuple(getattr(likelihood, "latents", ()))
    for relation_class, words in words_by_class().items():
        word = relation_class if relation_class in words else words[0]
        for figure, ground in itertools.product(("Figure", SPEAKER), ("House", "MainSt", "Pole")):
            for distance_m in (None, 25.0) if relation_class == "proximity" else (None,):
                relation = SpatialRelation(figure, word, (ground,), distance_m=distance_m)
                (term,) = ground_relations((relation,), city)
                for latent in latents:
                    if latent.is_about(term):
                        term = latent.apply(term, latent.support[0])
                angles: tuple[float, ...] = ()
                if term.needs_frame:
                    angles = _ANGLES
                elif term.compass_rad is not None:
                    angles = (term.compass_rad,)
                turned = torch.tensor([turn(a) for a in angles], dtype=torch.float64)
                yield _Case(term, turned if angles else None)


def _check_tables(likelihood: RelationLikelihood) -> None:
    for case in _cases(likelihood, _city()):
        table = case.table(likelihood)
        if not torch.allclose(case.table_at(likelihood, _SOME), table[..., _SOME], atol=1e-9):
            raise InputError(
                f"log_g of {_name(likelihood)} for {case.label} gives some cells other values "
                "alone than among all; expected each cell's value to depend on that cell only, "
                "from the term's tables, such as term.off_m"
            )
        if case.directions is None:
            continue
        for i in range(len(case.directions)):
            alone = likelihood.log_g(case.term, case.directions[i : i + 1])
            if alone.shape != table[i : i + 1].shape or not torch.allclose(
                alone, table[i : i + 1], atol=1e-9
            ):
                raise InputError(
                    f"log_g of {_name(likelihood)} for {case.label} gives direction "
                    f"{float(case.directions[i]):.2f} rad another value alone than among "
                    f"{len(case.directions)}; expected row b to depend on direction b only"
                )


def _check_gradients(likelihood: RelationLikelihood) -> None:
    name = _name(likelihood)
    tensors: dict[str, Tensor] = {}
    for parameter in parameters_of(likelihood):
        if not hasattr(likelihood, parameter.name):
            raise InputError(
                f"{name} declares parameter '{parameter.name}' but has no such field; add it"
            )
        value = parameter.checked(getattr(likelihood, parameter.name))
        tensors[parameter.name] = torch.tensor(value, dtype=torch.float64, requires_grad=True)
    learning = with_values(likelihood, tensors)
    reached = dict.fromkeys(tensors, False)
    for case in _cases(likelihood, _city()) if tensors else ():
        total = case.table(learning).sum()
        if not total.requires_grad:
            continue
        slopes = torch.autograd.grad(total, list(tensors.values()), allow_unused=True)
        for which, slope in zip(tensors, slopes, strict=True):
            if slope is not None and not bool(torch.isfinite(slope)):
                raise InputError(
                    f"The gradient of {name} in '{which}' is {float(slope)} for {case.label}; "
                    "expected a finite number: mind torch.where over NaN, and sqrt(0)"
                )
            reached[which] = reached[which] or (slope is not None and float(slope) != 0)
    for which, did in reached.items():
        if not did:
            raise InputError(
                f"No gradient of {name} reaches parameter '{which}'; compute with torch and leave "
                "float() and math out, or do not declare it"
            )


def _check_turning(likelihood: RelationLikelihood) -> None:
    """Turn by 90 degrees anticlockwise, and mirror east with west."""
    moves: tuple[tuple[str, CityMap, Callable[[float], float], Callable[[Tensor], Tensor]], ...] = (
        ("turning", _city(move=lambda x, y: (-y, x)), lambda a: a + math.pi / 2, _quarter_turn),
        ("mirroring", _city(move=lambda x, y: (-x, y)), lambda a: math.pi - a, _east_for_west),
    )
    for what, city, turn, move in moves:
        for case, moved in zip(
            _cases(likelihood, _city()), _cases(likelihood, city, turn), strict=True
        ):
            before = move(_square(case.table(likelihood)))
            off = float((before - _square(moved.table(likelihood))).abs().max())
            if off > 1e-6:
                raise InputError(
                    f"{what.capitalize()} map and direction does not do so to log_g of "
                    f"{_name(likelihood)} for {case.label}: off by {off:.3g}; expected it "
                    "to depend on distance, on term.bearing_rad less direction_rad, and not on "
                    "east or north; if it is absolute by intention, leave this out: "
                    'check_likelihood(..., skip=("rotation",))'
                )


def _check_cells(likelihood: RelationLikelihood) -> None:
    """Halve the cells and compare the mass of blocks of 10 m."""
    for case, finer in zip(
        _cases(likelihood, _city()), _cases(likelihood, _city(_CELL_M / 2)), strict=True
    ):
        masses = []
        for one in (case, finer):
            g = _square(one.table(likelihood)).exp()
            side = round(_BLOCK_M / one.term.city.grid.cell_m)
            blocks = g.unfold(-2, side, side).unfold(-2, side, side).sum((-2, -1))
            masses.append(blocks / blocks.sum((-2, -1), keepdim=True))
        moved = float(0.5 * (masses[0] - masses[1]).abs().sum((-2, -1)).max())
        if moved > _MOST_MOVED:
            raise InputError(
                f"Halving the cells moves {moved:.2g} of the mass of {_name(likelihood)} "
                f"for {case.label}; expected at most {_MOST_MOVED:g}: take distances in metres, "
                "from term.distance_m or term.off_m, and not in cells"
            )


def _check_marginal(likelihood: RelationLikelihood) -> None:
    if not isinstance(likelihood, ClosedFormMarginal):
        return
    steps = torch.arange(_QUADRATURE, dtype=torch.float64)
    frame_angles = steps * (2 * math.pi / _QUADRATURE) - math.pi
    for case in _cases(likelihood, _city()):
        term = case.term
        if term.relation_class not in ("front", "right"):
            continue
        g = likelihood.log_g(term, frame_angles + term.offset_rad).exp()
        change = (g - g.roll(1, 0)).abs()
        jumps = torch.where(change > _JUMP, change, 0.0).sum(0)
        for frame_label, frame in _FRAMES.items():
            what = f"log_marginal of {_name(likelihood)} for {case.label} under {frame_label}"
            table = check_table(likelihood.log_marginal(term, frame), (term.n_cells,), what).exp()
            expected, densest = _by_quadrature(likelihood, term, frame, frame_angles, g)
            # Where g jumps with direction, a sum over steps can be off by a step's mass.
            off = (table - expected).abs() - 2 * densest * jumps
            if float(off.max()) > 1e-5:
                raise InputError(
                    f"{what} is off by {float((table - expected).abs().max()):.3g} from "
                    "quadrature of log_g; correct it, or leave log_marginal out"
                )


def _by_quadrature(
    likelihood: RelationLikelihood,
    term: GroundedRelation,
    frame: FrameDistribution,
    frame_angles: Tensor,
    g: Tensor,
) -> tuple[Tensor, float]:
    """Return E[g] over a frame, shape (S,), and the greatest mass of one step."""
    mass = torch.full_like(frame_angles, frame.lapse / len(frame_angles))
    points = torch.zeros(g.shape[-1], dtype=torch.float64)
    for part in frame.parts:
        if math.isinf(part.kappa):
            at = torch.tensor([part.mean_rad + term.offset_rad], dtype=torch.float64)
            points = points + part.weight * likelihood.log_g(term, at).exp()[0]
        else:
            shape = torch.softmax(part.kappa * torch.cos(frame_angles - part.mean_rad), 0)
            mass = mass + part.weight * shape
    return points + mass @ g, float(mass.max())


def _quarter_turn(table: Tensor) -> Tensor:
    turned: Tensor = torch.rot90(table, -1, [-2, -1])
    return turned


def _east_for_west(table: Tensor) -> Tensor:
    mirrored: Tensor = torch.flip(table, [-1])
    return mirrored


def _square(table: Tensor) -> Tensor:
    side = math.isqrt(table.shape[-1])
    return table.reshape(*table.shape[:-1], side, side)


def _name(likelihood: RelationLikelihood) -> str:
    """Return what to call a likelihood: its own name if it carries one, else its type's."""
    return str(getattr(likelihood, "name", type(likelihood).__name__))


_PROMISES: dict[str, Callable[[RelationLikelihood], None]] = {
    "tables": _check_tables,
    "gradients": _check_gradients,
    "rotation": _check_turning,
    "cells": _check_cells,
    "marginal": _check_marginal,
}
