"""The joint weight of two targets' cells, multiplied with tables without being laid out itself.

Shape legend: S cells; R values of all other latents of a table.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock

import torch
from scipy.fft import next_fast_len
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference._log_tables import LogTable
from sloop_ppl.models import PairKernel

__all__ = ["MOST_NUMBERS", "PairGroup", "PairTable", "pair_groups", "pair_table"]

_DENSE = 1 << 23
"""Numbers of a table that is kept: 41 x 41 cells squared are 2.8 million, 53 x 53 7.9 million."""

_BLOCK = 1 << 21
"""Numbers that are laid out at once, where a table is not kept: 16 MiB."""

MOST_NUMBERS = 1 << 26
"""Numbers of the largest joint of two cells that is laid out: 512 MiB."""

_MOST_KEPT = 4
"""Tables that are kept of one phrase: with others, under several readings."""

_LOCK = Lock()
"""Held while a kept table is looked up: posteriors are asked from many threads."""

_DEEP = -650.0
"""Log factors above this can be multiplied as exponentials."""


@dataclass(frozen=True, eq=False)
class PairTable:
    """Log weights of the cells of two targets: all that was said of how these two lie apart.

    Parameters
    ----------
    first, second
        Names of the two latents, ``T/cell``.
    kernels
        The phrases, with True for those whose figure is the second.
    """

    first: str
    second: str
    kernels: tuple[tuple[PairKernel, bool], ...]

    @property
    def n_cells(self) -> int:
        """How many cells each of the two may be in, S."""
        return self.kernels[0][0].n_cells

    def other(self, name: str) -> str:
        """Return the latent that is not this one of the two."""
        return self.second if name == self.first else self.first

    def log_rows(self, start: int, stop: int) -> Tensor:
        """Return the log weights of some cells of the second, over those of the first, (C, S)."""
        cells = torch.arange(start, stop)
        rows = [kernel.log_rows(cells, of_figure=reverse) for kernel, reverse in self.kernels]
        total = rows[0]
        for more in rows[1:]:
            total = total + more
        return total

    def summed(self, table: LogTable, name: str) -> LogTable:
        """Return the product with a table, one of the two latents summed out.

        Parameters
        ----------
        table
            A table with an axis for that latent and none for the other.
        name
            The latent.

        Returns
        -------
        LogTable
            The axes of the table's other latents, then that of the other cell.
        """
        rest = tuple(latent for latent in table.latents if latent != name)
        log_p = table.aligned((*rest, name))
        shape = (*log_p.shape[:-1], self.n_cells)
        flat = log_p.reshape(-1, self.n_cells)
        top = flat.max(-1, keepdim=True).values
        top = torch.where(torch.isfinite(top), top, 0.0)
        weights = (flat - top).exp()
        expansion = None if self._is_kept else self._expansion
        if expansion is not None:
            found = self._convolved(weights, *expansion, of_second=name == self.second).log() + top
            return LogTable((*rest, self.other(name)), found.reshape(shape))
        found = torch.zeros_like(flat)
        parts: list[Tensor] = []
        for start, stop, log_rows in self._blocks():
            block = slice(start, stop)
            if name == self.second and self._can_multiply:
                found += weights[:, block] @ self._exponential(log_rows)
            elif name == self.second:
                part = _log_product(flat[:, block], log_rows)
                parts = [part if not parts else torch.logaddexp(parts[0], part)]
            elif self._can_multiply:
                found[:, block] = weights @ self._exponential(log_rows).T
            else:
                found[:, block] = _log_product(flat, log_rows.T)
        if self._can_multiply:
            found = found.log() + top
        elif parts:
            found = parts[0]
        return LogTable((*rest, self.other(name)), found.reshape(shape))

    def _convolved(
        self, weights: Tensor, over_second: Tensor, apart: Tensor, *, of_second: bool
    ) -> Tensor:
        """Return sums of products with weights of one latent's cells, by Fourier, (R, S)."""
        grid = self.kernels[0][0].city.grid
        rows, cols = grid.shape
        size = next_fast_len(2 * rows - 1, True), next_fast_len(2 * cols - 1, True)
        tables = weights.reshape(-1, rows, cols)
        each = over_second.reshape(-1, rows, cols)
        found = torch.zeros_like(tables)
        for share, table in zip(each, apart, strict=True):
            # s1 = s2 + displacement; the other way round displacements change their sign
            kernel = torch.fft.rfft2(table if of_second else table.flip(0, 1), s=size)
            some = torch.fft.rfft2(tables * share if of_second else tables, s=size)
            part = torch.fft.irfft2(some * kernel, s=size)
            part = part[:, rows - 1 : 2 * rows - 1, cols - 1 : 2 * cols - 1]
            found += part if of_second else part * share
        # What cancels below rounding must not become negative.
        return found.clamp_min(0.0).reshape(-1, self.n_cells)

    @cached_property
    def _expansion(self) -> tuple[Tensor, Tensor] | None:
        """Weights of the second's cells and tables of displacements, of one phrase alone."""
        (kernel, reverse), *others = self.kernels
        return None if others or reverse else kernel.expansion()

    def table(self) -> LogTable:
        """Return all of it as a table.

        Raises
        ------
        InputError
            When it would not fit in memory.
        """
        if self.n_cells**2 > MOST_NUMBERS:
            raise InputError(
                f"The joint of {self.first} and {self.second} would take a table of "
                f"{float(self.n_cells**2):.1e} numbers; relations between targets must not form a "
                "circle on a map of so many cells; say fewer, or ask for one cell at a time"
            )
        rows = [log_rows for _, _, log_rows in self._blocks()]
        return LogTable((self.second, self.first), torch.cat(rows))

    @cached_property
    def _can_multiply(self) -> bool:
        return sum(kernel.least for kernel, _ in self.kernels) > _DEEP

    @cached_property
    def _kept(self) -> Tensor:
        return self.log_rows(0, self.n_cells)

    @cached_property
    def _kept_exponential(self) -> Tensor:
        return self._kept.exp()

    @property
    def _is_kept(self) -> bool:
        return self.n_cells**2 <= _DENSE

    def _blocks(self) -> Iterator[tuple[int, int, Tensor]]:
        """Yield first and last cell of the second, and the log weights there."""
        if self._is_kept:
            yield 0, self.n_cells, self._kept
            return
        step = max(1, _BLOCK // self.n_cells)
        for start in range(0, self.n_cells, step):
            stop = min(start + step, self.n_cells)
            yield start, stop, self.log_rows(start, stop)

    def _exponential(self, log_rows: Tensor) -> Tensor:
        return self._kept_exponential if self._is_kept else log_rows.exp_()


def _log_product(left: Tensor, right: Tensor) -> Tensor:
    """Return the log of a matrix product of exponentials, shapes (R, C) and (C, S)."""
    return torch.stack([torch.logsumexp(row[:, None] + right, 0) for row in left])


@dataclass(frozen=True, eq=False)
class PairMember:
    """A phrase about two targets among others.

    Parameters
    ----------
    kernel
        The phrase.
    reverse
        Whether its figure is the second of the two.
    gates
        Name of a latent -> the positions of the values under which it is said.
    """

    kernel: PairKernel
    reverse: bool
    gates: Mapping[str, frozenset[int]]

    def log_silent(self) -> float:
        """Return its log factor where it is not said.

        A mention that may be a place too is counted there: the phrase is then silent itself.
        """
        return 0.0 if self.kernel.is_alternative else self.kernel.log_silent


@dataclass(frozen=True, eq=False)
class PairGroup:
    """Log weights of the cells of two targets, under the readings and referents they depend on.

    Parameters
    ----------
    first, second
        Names of the two latents, ``T/cell``.
    members
        The phrases.
    gate_sizes
        Name of each latent that tells whether a phrase is said -> number of its values.
    """

    first: str
    second: str
    members: tuple[PairMember, ...]
    gate_sizes: Mapping[str, int]

    @property
    def cells(self) -> tuple[str, str]:
        """Names of the two cells."""
        return self.first, self.second

    @property
    def latents(self) -> tuple[str, ...]:
        """Names of all its latents."""
        return (*self.cells, *self.gate_sizes)

    @property
    def n_cells(self) -> int:
        """How many cells each of the two may be in, S."""
        return self.members[0].kernel.n_cells

    @property
    def sizes(self) -> dict[str, int]:
        """Number of values of each latent."""
        return {**dict.fromkeys(self.cells, self.n_cells), **self.gate_sizes}

    def other(self, name: str) -> str:
        """Return the cell that is not this one of the two."""
        return self.second if name == self.first else self.first

    def summed(self, table: LogTable, name: str) -> LogTable:
        """Return the product with a table, one of the two cells summed out.

        Parameters
        ----------
        table
            A table with an axis for that cell and none for the other.
        name
            The cell.

        Returns
        -------
        LogTable
            The axes of the table's other latents, those of the gates, and that of the other cell.
        """
        known = [gate for gate in self.gate_sizes if gate in table.latents]
        rest = tuple(n for n in table.latents if n != name and n not in known)
        log_p = table.aligned((*known, *rest, name))
        parts = []
        for setting, pairs, level in self._settings():
            at = tuple(v for gate, v in zip(self.gate_sizes, setting, strict=True) if gate in known)
            some = LogTable((*rest, name), log_p[at])
            if pairs is None:
                total = torch.logsumexp(some.values, -1, keepdim=True)
                values = total.expand(*total.shape[:-1], self.n_cells)
            else:
                values = pairs.summed(some, name).values
            parts.append(values + level if level else values)
        if not self.gate_sizes:
            return LogTable((*rest, self.other(name)), parts[0])
        stacked = torch.stack(parts).reshape(*self.gate_sizes.values(), *parts[0].shape)
        return LogTable((*self.gate_sizes, *rest, self.other(name)), stacked)

    def table(self) -> LogTable:
        """Return all of it as a table.

        Raises
        ------
        InputError
            When it would not fit in memory.
        """
        parts = []
        for _, pairs, level in self._settings():
            if pairs is None:
                parts.append(torch.full((self.n_cells, self.n_cells), level, dtype=torch.float64))
            else:
                parts.append(pairs.table().values + level)
        stacked = torch.stack(parts).reshape(*self.gate_sizes.values(), *parts[0].shape)
        return LogTable((*self.gate_sizes, self.second, self.first), stacked)

    def _settings(self) -> Iterator[tuple[tuple[int, ...], PairTable | None, float]]:
        """Yield values of the gates, what is said under them, and the level of what is not."""
        for setting in itertools.product(*map(range, self.gate_sizes.values())):
            at = dict(zip(self.gate_sizes, setting, strict=True))
            active, level = [], 0.0
            for one in self.members:
                if all(at[gate] in values for gate, values in one.gates.items()):
                    active.append((one.kernel, one.reverse))
                    level -= one.kernel.log_silent if one.kernel.is_alternative else 0.0
                else:
                    level += one.log_silent()
            pairs = _kept_table(self.first, self.second, tuple(active)) if active else None
            yield setting, pairs, level


def pair_groups(
    kernels: Sequence[tuple[PairKernel, Mapping[str, frozenset[int]]]],
    gate_sizes: Mapping[str, int],
) -> tuple[PairGroup, ...]:
    """Return one factor for each two targets that phrases relate.

    Parameters
    ----------
    kernels
        The phrases, each with its gates; see `PairMember`.
    gate_sizes
        Name of each gate -> number of its values.
    """
    together: dict[tuple[str, str], list[PairMember]] = {}
    for kernel, gates in kernels:
        figure, ground = f"{kernel.figure}/cell", f"{kernel.ground}/cell"
        reverse = (ground, figure) in together
        key = (ground, figure) if reverse else (figure, ground)
        together.setdefault(key, []).append(PairMember(kernel, reverse, gates))
    return tuple(
        PairGroup(
            *key,
            tuple(some),
            {name: size for name, size in gate_sizes.items() if any(name in m.gates for m in some)},
        )
        for key, some in together.items()
    )


def pair_table(kernel: PairKernel) -> PairTable:
    """Return the weight of the cells of the two targets of one phrase, as it was meant."""
    return _kept_table(f"{kernel.figure}/cell", f"{kernel.ground}/cell", ((kernel, False),))


def _kept_table(first: str, second: str, kernels: tuple[tuple[PairKernel, bool], ...]) -> PairTable:
    """Return the table of some kernels, made once: each look of a search asks for it again."""
    kept = kernels[0][0].tables
    key = (first, second, *((id(kernel), reverse) for kernel, reverse in kernels))
    with _LOCK:
        if key not in kept:
            if len(kept) >= _MOST_KEPT:  # what was said with others before is asked for no more
                kept.pop(next(iter(kept)))
            kept[key] = PairTable(first, second, kernels)
        table: PairTable = kept[key]
    return table
