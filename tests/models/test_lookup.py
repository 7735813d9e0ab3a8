"""Looking tables up gives what indexing gives, as a view where it can."""

from __future__ import annotations

import pytest
import torch

from sloop_ppl.models.lookup import look_up

TABLE = torch.arange(24.0).reshape(2, 3, 4)


def sweep(size, dim):
    return torch.arange(size).reshape([-1] + [1] * (-dim - 1))


@pytest.mark.parametrize(
    "index",
    [
        (torch.tensor(1), sweep(3, -2), sweep(4, -1)),
        (sweep(2, -3), sweep(3, -1), sweep(4, -2)),
        (sweep(2, -1), torch.tensor([[2]]), sweep(4, -4)),
        (torch.tensor(1), torch.tensor(0), torch.tensor(3)),
    ],
)
def test_a_sweep_of_whole_axes_is_a_view(index):
    got = look_up(TABLE, index)
    assert torch.equal(got, TABLE[tuple(torch.broadcast_tensors(*index))])
    assert got.untyped_storage().data_ptr() == TABLE.untyped_storage().data_ptr()


@pytest.mark.parametrize(
    "index",
    [
        (torch.tensor(1), torch.tensor([2, 1, 0]), sweep(4, -2)),  # backwards
        (torch.tensor([0, 1]), sweep(3, -2), torch.tensor([3, 3])),  # drawn
        (torch.tensor([0, 1]), torch.tensor([0, 2]), torch.tensor([1, 1])),  # pairs
        (sweep(2, -2), sweep(3, -1), torch.tensor([[0, 1, 2], [3, 2, 1]])),
    ],
)
def test_anything_else_is_indexed(index):
    assert torch.equal(look_up(TABLE, index), TABLE[tuple(torch.broadcast_tensors(*index))])


def test_two_axes_swept_along_one_dim_are_a_diagonal():
    square = torch.arange(9.0).reshape(3, 3)
    assert torch.equal(look_up(square, (torch.arange(3), torch.arange(3))), square.diagonal())
