"""Draw cells, components and frames together from a posterior, and hand the draws to ArviZ.

Shape legend: n draws; K components; M angles.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.factors import DescriptionFactor, site_name
from sloop_ppl.inference.frames import Framed, FramePosterior, framed_relations
from sloop_ppl.inference.joint import JointPosterior
from sloop_ppl.maps import Grid
from sloop_ppl.models import SharedFrame

if TYPE_CHECKING:
    import xarray

__all__ = [
    "CHAINS",
    "PhraseWord",
    "draws_from",
    "import_arviz",
    "inverse",
    "to_arviz",
    "uniforms_for",
]

Table = NDArray[np.float64]
CHAINS = 4
"""Chains of draws for ArviZ, which warns of fewer."""

_BINS = 72  # 5 degrees, within which a front is drawn evenly
_AT_ONCE = 10_000  # draws, times the bins: a table of 6 MB


class PhraseWord(NamedTuple):
    """An asserted phrase as a choice among words, at each draw.

    Attributes
    ----------
    label
        Its target, word and grounds.
    words
        The words that could have been said of its ground, V of them.
    word
        Which of them it counts as.
    p
        Probability of each at each draw, shape (V, n).
    uniforms
        Numbers in [0, 1) by which words are drawn, shape (n,).
    """

    label: str
    words: tuple[str, ...]
    word: str
    p: Table
    uniforms: Table


def uniforms_for(
    factors: Sequence[DescriptionFactor], target: str, n: int, rng: np.random.Generator | None
) -> Table:
    """Return the numbers that n draws take: for the cell, the components and the frames.

    Parameters
    ----------
    n
        How many draws, > 0.
    rng
        Where the numbers are drawn from; None for a lattice, the same every time.

    Raises
    ------
    InputError
        When `n` is not positive.
    """
    if n < 1:
        raise InputError(f"n is {n}; expected at least one draw")
    n_informative = sum(target in factor.log_factors for factor in factors)
    needed = 1 + n_informative + 2 * len(framed_relations(factors, target))
    return _lattice(n, needed) if rng is None else rng.random((n, needed))


def draws_from(
    joint: JointPosterior,
    factors: Sequence[DescriptionFactor],
    grid: Grid,
    target: str,
    uniforms: Table,
) -> xarray.Dataset:
    """Turn uniform numbers into draws from the joint posterior of a target.

    Parameters
    ----------
    joint
        What is drawn from.
    uniforms
        Numbers in [0, 1), shape (n, D), from `uniforms_for`.

    Returns
    -------
    xarray.Dataset
        ``x`` and ``y``, centres of the drawn cells in metres, and ``row`` and ``col`` (dim draw);
        ``component`` (draw, description); ``front``, radians from east in [-pi, pi) (draw,
        frame), with the ``ground`` and the ``relation`` of each frame.

    Notes
    -----
    Ancestral: cell ~ belief; component ~ p(z | cell) for each description, independent given the
    cell; front ~ p(psi | cell, z), which is its prior when z leaves frames out. A front that is
    not a point is drawn evenly within its bin of a degree.
    """
    import xarray

    informative = [which for which, factor in enumerate(factors) if target in factor.log_factors]
    cells = inverse(joint.probabilities(f"{target}/cell"), uniforms[:, 0])
    rows, cols = np.divmod(cells, grid.n_cols)
    chosen = np.zeros((len(cells), len(informative)), dtype=np.intp)
    names: Table = np.array([], dtype=str)
    for column, which in enumerate(informative):
        component = site_name(f"{target}/component", which)
        weights = joint.probabilities(component, f"{target}/cell")[:, cells]
        chosen[:, column] = _by_column(weights, uniforms[:, 1 + column])
        names = np.array(factors[which].components)
    framed = framed_relations(factors, target)
    angles = np.zeros((len(cells), len(framed)))
    for k, frame in enumerate(framed):
        own = FramePosterior(joint, factors[frame.which], target, frame)
        # Phrases of one description that share a front draw it with the same numbers.
        same = (f for f in range(k) if _share(factors, framed[f], frame))
        column = 1 + len(informative) + 2 * next(same, k)
        for start in range(0, len(cells), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            pick, within = uniforms[part, column], uniforms[part, column + 1]
            components = chosen[part, informative.index(frame.which)]
            angles[part, k] = _drawn_angles(
                joint, factors, target, own, frame, cells[part], components, pick, within
            )
    return xarray.Dataset(
        {
            "x": ("draw", grid.x_m[cols], {"units": "m"}),
            "y": ("draw", grid.y_m[rows], {"units": "m"}),
            "row": ("draw", rows),
            "col": ("draw", cols),
            "component": (
                ("draw", "description"),
                names[chosen] if informative else chosen.astype(str),
            ),
            "front": (("draw", "frame"), angles, {"units": "rad"}),
        },
        coords={
            "ground": ("frame", np.array([f.term.ground for f in framed], dtype=str)),
            "relation": ("frame", np.array([f.term.relation for f in framed], dtype=str)),
        },
        attrs={"target": target},
    )


def to_arviz(
    draws: Mapping[str, xarray.Dataset],
    names: Sequence[str],
    constants: xarray.Dataset,
    attrs: Mapping[str, Any],
    prior: Mapping[str, tuple[NDArray[np.intp], Mapping[str, float]]],
    phrases: Sequence[PhraseWord],
) -> Any:
    """Return an ArviZ InferenceData of draws from a posterior.

    Parameters
    ----------
    draws
        Target -> draws, from `draws_from`, a multiple of `CHAINS`.
    names
        Names of the components.
    constants
        Exact tables, for the group ``constant_data``.
    attrs
        Attributes of the group ``posterior``.
    prior
        Target -> cells drawn from its prior, and the prior weights of the components.
    phrases
        The phrases as choices among words.

    Returns
    -------
    arviz.InferenceData
        Group ``posterior`` with, for each target T, ``T_x``, ``T_y`` (metres), ``T_component``
        (index into the attribute ``components``, one per description), ``T_is`` (1 for the drawn
        component, by its name, dims description and component; both are left out where one
        component has all of the draws) and ``T_front`` (radians, one per
        frame); group ``prior`` with ``T_x``, ``T_y`` and ``T_is``, the prior weight of each
        component; groups ``posterior_predictive``, ``observed_data`` and ``log_likelihood`` with
        ``word``, an index into the attribute ``words``, by phrase; group ``constant_data`` with the
        exact ``belief`` and ``log_prior`` over cells.

    Raises
    ------
    InputError
        When ArviZ is not installed, or is a version without InferenceData.

    Notes
    -----
    The draws are independent, so r-hat and effective sample sizes say nothing about them; entropy
    and HPD regions are exact in the Posterior itself.
    """
    import xarray

    arviz = import_arviz()
    drawn: dict[str, xarray.DataArray] = {}
    for target, table in draws.items():
        index = np.searchsorted(np.sort(names), table["component"].values)
        coded = table.copy()
        coded["component"] = table["component"].copy(data=np.argsort(names)[index])
        coded = coded.drop_vars(["row", "col", "ground", "relation"]).expand_dims(chain=[0])
        coded = coded.assign_coords(draw=np.arange(table.sizes["draw"]))
        own = {"description": f"{target}_description", "frame": f"{target}_frame"}
        for name, array in coded.data_vars.items():
            if array.size:
                drawn[f"{target}_{name}"] = array.rename(
                    {k: v for k, v in own.items() if k in array.dims}
                )
    for target in draws:
        chosen = drawn.get(f"{target}_component")
        if chosen is not None and (chosen == chosen[0, 0]).all():
            del drawn[f"{target}_component"]  # of what does not vary there are no statistics
        elif chosen is not None:
            known = xarray.DataArray(
                np.arange(len(names)), dims="component", coords={"component": list(names)}
            )
            drawn[f"{target}_is"] = (chosen == known).astype(float)
    groups = {
        "posterior": xarray.Dataset(drawn, attrs=dict(attrs)),
        "prior": _prior_group(prior, names, constants, attrs),
        "constant_data": constants,
        **(_word_groups(phrases) if phrases else {}),
    }
    return arviz.InferenceData(**{name: _in_chains(table) for name, table in groups.items()})


def _in_chains(table: xarray.Dataset) -> xarray.Dataset:
    """Return a group with its draws dealt out to the chains, so that each is as even as all."""
    import xarray

    drawn: dict[str, Any] = {}
    for name, array in table.data_vars.items():
        if "draw" in array.dims:
            ordered = array.transpose("chain", "draw", ...)
            values = ordered.values[0]
            values = values.reshape(-1, CHAINS, *values.shape[1:]).swapaxes(0, 1)
            drawn[str(name)] = (ordered.dims, values, array.attrs)
        else:
            drawn[str(name)] = array
    coords = {k: c for k, c in table.coords.items() if k not in ("chain", "draw")}
    dealt = xarray.Dataset(drawn, coords=coords, attrs=table.attrs)
    if "draw" not in dealt.dims:
        return dealt
    return dealt.assign_coords(chain=np.arange(CHAINS), draw=np.arange(dealt.sizes["draw"]))


def _prior_group(
    prior: Mapping[str, tuple[NDArray[np.intp], Mapping[str, float]]],
    names: Sequence[str],
    constants: xarray.Dataset,
    attrs: Mapping[str, Any],
) -> xarray.Dataset:
    """Return the draws from the prior."""
    import xarray

    x, y = constants["x"].values, constants["y"].values
    found: dict[str, Any] = {}
    for target, (cells, weights) in prior.items():
        rows, cols = np.divmod(cells, len(x))
        found[f"{target}_x"] = (("chain", "draw"), x[cols][None], {"units": "m"})
        found[f"{target}_y"] = (("chain", "draw"), y[rows][None], {"units": "m"})
        if weights:
            share = np.array([weights.get(name, 0.0) for name in names])
            each = np.broadcast_to(share, (1, len(cells), len(names)))
            found[f"{target}_is"] = (("chain", "draw", "component"), each)
    return xarray.Dataset(found, coords={"component": list(names)}, attrs=dict(attrs))


def _word_groups(phrases: Sequence[PhraseWord]) -> dict[str, xarray.Dataset]:
    """Return what was said, what would be, and how probable what was said is."""
    import xarray

    words = sorted({word for phrase in phrases for word in phrase.words})
    coords = {"phrase": [phrase.label for phrase in phrases]}
    drawn, observed, log_p = [], [], []
    for phrase in phrases:
        numbers = np.array([words.index(word) for word in phrase.words])
        drawn.append(numbers[_by_column(phrase.p, phrase.uniforms)])
        observed.append(words.index(phrase.word))
        log_p.append(np.log(phrase.p[phrase.words.index(phrase.word)]))
    by_draw = ("chain", "draw", "phrase")

    def group(dims: tuple[str, ...], values: Table | NDArray[np.intp]) -> xarray.Dataset:
        return xarray.Dataset({"word": (dims, values)}, coords=coords, attrs={"words": words})

    return {
        "posterior_predictive": group(by_draw, np.stack(drawn, -1)[None]),
        "observed_data": group(("phrase",), np.array(observed)),
        "log_likelihood": group(by_draw, np.stack(log_p, -1)[None]),
    }


def import_arviz() -> Any:
    """Import ArviZ without its notice about the coming version."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            import arviz
    except ImportError as error:
        raise InputError(
            "ArviZ is not installed; install it with: pip install 'sloop-ppl[arviz]'"
        ) from error
    if not hasattr(arviz, "InferenceData"):
        raise InputError(
            f"ArviZ {arviz.__version__} has no InferenceData; expected a version below 1: pip "
            "install 'sloop-ppl[arviz]'"
        )
    return arviz


def _lattice(n: int, dimensions: int) -> Table:
    """Return n points that fill the unit cube evenly, the same at every call, shape (n, D).

    Notes
    -----
    Source: Roberts (2018), "The unreasonable effectiveness of quasirandom sequences": multiples
    of the inverse powers of the root of x^(D+1) = x + 1, modulo one.
    """
    # By hand, not scipy.stats.qmc: it has no such lattice and takes 0.6 s of CPU to import. Its
    # Sobol points miss the mean of the bundled beliefs by as much (0.2 m at 1000 draws), are even
    # only where n is a power of 2, and would change what the same posterior draws.
    root = 2.0
    for _ in range(64):
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1, dimensions + 1)
    points: Table = (0.5 + np.outer(np.arange(1, n + 1), steps)) % 1.0
    return points


def inverse(weights: Table, uniforms: Table) -> NDArray[np.intp]:
    """Return the index at which the running sum of the weights passes each number."""
    running = np.cumsum(weights)
    passed = np.searchsorted(running, uniforms * running[-1], side="right")
    found: NDArray[np.intp] = np.minimum(passed, np.flatnonzero(weights)[-1])
    return found


def _by_column(weights: Table, uniforms: Table) -> NDArray[np.intp]:
    """Draw a row for every column of weights, shape (M, n), with one number each."""
    running = np.cumsum(weights, 0)
    passed = (uniforms * running[-1] >= running).sum(0)
    drawn: NDArray[np.intp] = np.minimum(passed, len(weights) - 1)
    return drawn


def _share(factors: Sequence[DescriptionFactor], one: Framed, other: Framed) -> bool:
    """Tell whether two phrases speak of one front."""
    shared = [v.ground for v in factors[one.which].data.shared if isinstance(v, SharedFrame)]
    same = (one.which, one.term.ground) == (other.which, other.term.ground)
    return same and one.term.ground in shared


def _drawn_angles(
    joint: JointPosterior,
    factors: Sequence[DescriptionFactor],
    target: str,
    own: FramePosterior,
    framed: Framed,
    cells: NDArray[np.intp],
    components: NDArray[np.intp],
    pick: Table,
    within: Table,
) -> Table:
    """Draw one front for each drawn cell and component."""
    axis = own.tables.phrase.shared_axis
    if axis is not None:
        shared = factors[framed.which].data.shared[axis]
        angles = np.array(shared.support)
        names = (
            site_name(shared.name, framed.which),
            site_name(f"{target}/component", framed.which),
        )
        weights = joint.probabilities(*names, f"{target}/cell")
        node = _by_column(weights[:, components, cells], pick)
    else:
        angles, mass, _ = own.nodes(_BINS)
        mass = mass * own.answer_likelihood(angles)
        uses = np.array([part.uses_frames for part in factors[framed.which].data.model.components])
        places, home = np.unique(cells, return_inverse=True)
        weighted = mass[:, None] * own.ratio_at(angles, places)
        node = _by_column(np.where(uses[components], weighted[:, home], mass[:, None]), pick)
    points = [part.mean_rad for part in own.prior.parts if math.isinf(part.kappa)]
    width = 2 * math.pi / max(len(np.unique(angles)) - len(points), 1)
    jitter = np.where(np.isin(angles[node], points), 0.0, (within - 0.5) * width)
    drawn: Table = (angles[node] + jitter + math.pi) % (2 * math.pi) - math.pi
    return drawn
