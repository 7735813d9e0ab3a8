"""Look tables up at the values of discrete sites, without a copy where all values are wanted."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from pyro.ops.indexing import vindex
from torch import Tensor

__all__ = ["look_up"]


def look_up(table: Tensor, index: Sequence[Tensor]) -> Tensor:
    """Return the table's entries at some indices, which broadcast against each other.

    Parameters
    ----------
    table : any table.
    index : whole numbers, one tensor for each axis of the table.

    Returns
    -------
    Tensor
        Shape of the indices broadcast together. Where each index is one number or all of an axis
        in order, as enumeration and plates make it, it is a view of the table.
    """
    view = table
    dims: list[int] = []
    for axis in reversed(range(table.dim())):
        dim = _swept(index[axis], table.shape[axis])
        if dim is None or (dim and dim in dims):
            picked: Tensor = vindex(table, tuple(index))
            return picked
        if dim:
            dims.insert(0, dim)
        else:
            view = view.select(axis, int(index[axis]))
    order = sorted(range(len(dims)), key=lambda axis: dims[axis])
    shape = [1] * max(part.dim() for part in index)
    for axis, dim in enumerate(dims):
        shape[dim] = view.shape[axis]
    return view.permute(order).reshape(shape)


def _swept(index: Tensor, size: int) -> int | None:
    """Return the dim, below 0, along which an index runs through an axis; 0 for one number."""
    if index.numel() == 1:
        return 0
    if index.numel() != size or max(index.shape) != size:
        return None
    if not torch.equal(index.reshape(-1), torch.arange(size)):
        return None
    return list(index.shape).index(size) - index.dim()
