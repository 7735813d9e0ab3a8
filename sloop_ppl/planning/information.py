"""How much an answer is expected to tell of a target's cell, for many questions at once.

Shape legend: Q questions; A answers of one; S cells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import xlogy

from sloop_ppl.errors import InputError

__all__ = ["AnswerTables", "expected_bits", "realised_bits"]

Table = NDArray[np.float64]


class AnswerTables:
    """The answers of many questions about one target, stacked.

    Parameters
    ----------
    tables
        Probability of each answer at each cell, one table of shape (A, S) per question, columns
        summing to one; float32 is half the work and good to four digits.

    Raises
    ------
    InputError
        When there is none, or they are of different cells.

    Notes
    -----
    ``I(answer; cell) = H(sum_s b(s) p(. | s)) - sum_s b(s) H(p(. | s))`` in bits. The second
    entropy does not depend on the belief b and is taken once: later beliefs cost two products of a
    matrix with a vector.
    """

    def __init__(self, tables: Sequence[NDArray[np.floating[Any]]]) -> None:
        if not tables or len({table.shape[1] for table in tables}) != 1:
            raise InputError(
                "The tables of answers are of different cells, or there is none; expected at "
                "least one, each of shape (answers, cells)"
            )
        sizes = [len(table) for table in tables]
        self._starts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.intp)
        self._stacked = np.concatenate(tables)
        least = np.finfo(self._stacked.dtype).tiny  # 0 log 0 is 0
        self._noise = np.stack(
            [-(table * np.log(np.maximum(table, least))).sum(0) for table in tables]
        )

    def bits(self, belief: Table) -> Table:
        """Return the expected information of each question, bits, >= 0, shape (Q,).

        Parameters
        ----------
        belief
            Probability of each cell, summing to one, shape (S,).
        """
        weights = belief.astype(self._stacked.dtype, copy=False)
        p = (self._stacked @ weights).astype(np.float64)
        total = -np.add.reduceat(xlogy(p, p), self._starts)
        found: Table = np.maximum(total - self._noise @ weights, 0.0) / math.log(2)
        return found


def expected_bits(table: Table, belief: Table) -> float:
    """Return the expected information of one question; see `AnswerTables`.

    Examples
    --------
    >>> import numpy as np
    >>> float(expected_bits(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([0.5, 0.5])))
    1.0
    """
    return float(AnswerTables([table]).bits(belief)[0])


def realised_bits(before: Table, after: Table, cell: int) -> float:
    """Return by how many bits a belief rose at the true cell: its mean is the expected information.

    Parameters
    ----------
    before, after
        Belief before and after the answer, any shape.
    cell
        Flat index of the true cell.
    """
    least = 1e-300
    return math.log2(max(float(after.flat[cell]), least) / max(float(before.flat[cell]), least))
