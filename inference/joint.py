"""The joint posterior of all latents, as factors: what engines compute and posteriors answer from.

Shape legend: S cells; K components.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.special import softmax

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference._log_tables import LogTable, product_of
from sloop_ppl.inference._pairs import PairGroup

if TYPE_CHECKING:
    import xarray

__all__ = ["JointPosterior", "LogFactor", "LogTable", "sum_product"]

LogFactor: TypeAlias = LogTable | PairGroup
"""A factor of the posterior: a table, or the weight of two cells that is not laid out."""

_MOST_NUMBERS = 1 << 28
"""Of one intermediate table, 2 GiB in float64."""


def sum_product(factors: Sequence[LogFactor], keep: Sequence[str]) -> LogTable:
    """Sum all latents but some out of a product of factors.

    Parameters
    ----------
    factors
        The factors, at least one.
    keep
        Latents that stay.

    Returns
    -------
    LogTable
        With the axes of `keep` that occur, in that order.

    Raises
    ------
    InputError
        When an intermediate table would have more than 2^28 numbers.

    Notes
    -----
    Bucket elimination, the latent whose bucket is smallest first. Factors are added before they
    are exponentiated: Pyro's einsum multiplies exponentials shifted by each factor's own maximum,
    which underflow where two descriptions contradict each other by more than 745 nats. Of relations
    between targets the leaves of the tree come first: each is one product of a table and a matrix.
    """
    left = [factor for factor in factors if isinstance(factor, LogTable)]
    pairs = [factor for factor in factors if isinstance(factor, PairGroup)]
    sizes = {name: size for factor in factors for name, size in factor.sizes.items()}
    while True:
        known = [name for factor in left for name in factor.latents]
        known += [name for factor in pairs for name in factor.latents]
        others = {name for name in known if name not in keep}
        if not others:
            break
        costs = {name: _bucket_size(left, pairs, name, sizes) for name in others}
        name = min(sorted(costs), key=lambda name: costs[name])
        if costs[name] > _MOST_NUMBERS:
            raise InputError(
                f"Summing '{name}' out of the posterior would take a table of {costs[name]:.1e} "
                "numbers; ask for fewer latents at once, or say less at a time"
            )
        bucket = [table for table in left if name in table.latents]
        left = [table for table in left if name not in table.latents]
        own = [pair for pair in pairs if name in pair.latents]
        pairs = [pair for pair in pairs if name not in pair.latents]
        last = _last(bucket, own, name)
        bucket += [pair.table() for pair in own if pair is not last]
        product = product_of(bucket)
        left.append(product.summed(name) if last is None else last.summed(product, name))
    total = product_of([*left, *(pair.table() for pair in pairs)])
    order = tuple(name for name in keep if name in total.latents)
    return LogTable(order, total.aligned(order))


def _last(bucket: Sequence[LogTable], pairs: Sequence[PairGroup], name: str) -> PairGroup | None:
    """Return the pair that the others are multiplied with, to sum a latent out; None for none."""
    if not bucket:  # two cells of which nothing else is known
        return None
    met = {latent for table in bucket for latent in table.latents}
    fits = (p for p in pairs if name in p.cells and p.other(name) not in met)
    return next(fits, None)


def _bucket_size(
    tables: Sequence[LogTable], pairs: Sequence[PairGroup], name: str, sizes: Mapping[str, int]
) -> int:
    bucket = [table for table in tables if name in table.latents]
    own = [pair for pair in pairs if name in pair.latents]
    met = {latent for table in bucket for latent in table.latents} | {name}
    last = _last(bucket, own, name)
    for pair in own:
        met |= set(pair.gate_sizes) if pair is last else set(pair.latents)
    return math.prod(sizes[latent] for latent in met)


class LocalLatents(Protocol):
    """Latents that depend on each other and, given latents of the factors, on nothing else."""

    @property
    def names(self) -> Mapping[str, str]:
        """Their names in the joint posterior, as values."""

    def support(self, name: str) -> Sequence[Any]:
        """Return the values of one of them."""

    def log_conditional(self, asked: Sequence[str]) -> LogTable:
        """Return log p(asked | latents of the factors)."""


@dataclass(frozen=True, eq=False)
class JointPosterior:
    """The joint posterior of the latents of one or more descriptions.

    Latents are called as the program's sites: ``T/cell``, ``T/component``, ``T/frame_j``,
    ``T/lapse_j``, ``frame/G`` and declared ones; of the d-th later description with ``[d]``
    behind the name, its relations counted on from those before.

    Parameters
    ----------
    factors
        The factors whose product is the posterior, up to a constant.
    supports
        Latent of the factors -> its values, in the order of its axis; whole numbers for cells.
    local
        Latents of one phrase each, which the factors have summed out; they come back, given the
        others, when they are asked for.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> joint = sloop.infer("The red bike is west of Hoyt Block.", "cleveland").joint
    >>> joint.latents
    ('RedBike/cell', 'reading', 'RedBike/component', 'RedBike/lapse_0')
    >>> joint.probabilities("RedBike/cell", given={"RedBike/lapse_0": False}).shape
    (1681,)
    """

    factors: tuple[LogFactor, ...]
    supports: Mapping[str, Sequence[Any]]
    local: tuple[LocalLatents, ...] = ()
    _kept: dict[tuple[str, ...], LogTable] = field(default_factory=dict, repr=False)

    @property
    def latents(self) -> tuple[str, ...]:
        """Names of all latents."""
        return (*self.supports, *(name for each in self.local for name in each.names.values()))

    def support(self, latent: str) -> Sequence[Any]:
        """Return the values of a latent, in the order of its axis.

        Raises
        ------
        UnknownName
            When there is no such latent.
        """
        if latent in self.supports:
            return self.supports[latent]
        for each in self.local:
            if latent in each.names.values():
                return each.support(latent)
        raise UnknownName("latent", latent, self.latents)

    @property
    def log_evidence(self) -> float:
        """Log of the sum of the product of the factors."""
        first = tuple(self.supports)[:1]  # a marginal that is kept anyway: they all sum to it
        return float(torch.logsumexp(torch.from_numpy(self.log_weights(*first)).reshape(-1), 0))

    def log_weights(self, *latents: str) -> NDArray[np.float64]:
        """Return the log weights of some latents, all others summed out, one axis for each.

        Their log-sum is `log_evidence`.

        Raises
        ------
        UnknownName
            When there is no such latent.
        """
        shape = [len(self.support(name)) for name in latents]
        table = self._log_table(latents)
        # A latent that no factor has left is as likely everywhere.
        found: NDArray[np.float64] = table.aligned(latents).expand(shape).numpy()
        return found

    def probabilities(
        self, *latents: str, given: Mapping[str, Any] | None = None
    ) -> NDArray[np.float64]:
        """Return the joint probability of some latents, one axis for each, summing to one.

        Parameters
        ----------
        *latents
            Names; one gives its marginal, several their joint.
        given
            Latent -> value that it is known to have.

        Raises
        ------
        UnknownName
            When there is no such latent or value.
        InputError
            When what is given is impossible.
        """
        if not isinstance(given or {}, Mapping):
            raise InputError(
                f"`given` is {given!r}; expected a mapping of latents to values, such as "
                "{'T/component': 'literal'}"
            )
        known = dict(given or {})
        for name in latents:
            if not isinstance(name, str):
                raise InputError(
                    f"Latents are asked for by name and this is {name!r}; expected "
                    "probabilities('T/cell', 'T/component')"
                )
            if name in known or latents.count(name) > 1:
                raise InputError(
                    f"Latent '{name}' is asked for twice, or both asked for and given; expected "
                    "each once"
                )
        log_p = self.log_weights(*latents, *known)
        position: tuple[Any, ...] = tuple(self._position(n, v) for n, v in known.items())
        log_p = log_p[(..., *position)]
        if not np.isfinite(log_p.max()):
            raise InputError(f"What is given is impossible: {known}")
        normalised: NDArray[np.float64] = softmax(log_p)
        return normalised

    def table(self, *latents: str, given: Mapping[str, Any] | None = None) -> xarray.DataArray:
        """Return what `probabilities` does as a labelled array: dims are the latents' names."""
        import xarray

        return xarray.DataArray(
            self.probabilities(*latents, given=given),
            dims=latents,
            coords={name: list(self.support(name)) for name in latents},
            name="p",
        )

    def _position(self, name: str, value: Any) -> int:
        support = list(self.support(name))
        if value not in support:
            raise UnknownName(f"value of {name}", str(value), [str(v) for v in support[:20]])
        return support.index(value)

    def _log_table(self, latents: tuple[str, ...]) -> LogTable:
        if latents not in self._kept:
            # Latents of one phrase that are asked for, or that an answer informs.
            met = {name for factor in self.factors for name in factor.latents}
            wanted = [n for n in (*latents, *sorted(met)) if n not in self.supports]
            asked = []
            for local in self.local if wanted else ():
                own = [n for n in dict.fromkeys(wanted) if n in local.names.values()]
                asked += [local.log_conditional(own)] if own else []
            with torch.no_grad():
                self._kept[latents] = sum_product([*self.factors, *asked], latents)
        return self._kept[latents]
