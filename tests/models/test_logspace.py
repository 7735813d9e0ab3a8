"""Tables of log probabilities: looking up gives what indexing gives, as a view where it can."""

from __future__ import annotations

import math

import pytest
import torch

from sloop_ppl.models._logspace import LEAST_LOG, log1mexp, look_up

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


@pytest.mark.parametrize("index", [torch.tensor(1), torch.arange(2), torch.tensor([1, 1, 0])])
def test_an_axis_of_length_one_is_what_does_not_matter(index):
    """Any index finds its one entry, the impossible twin's too."""
    table = torch.arange(4.0).reshape(1, 4)
    got = look_up(table, (index, torch.tensor(2)))
    assert torch.equal(got.expand(index.shape), torch.full(index.shape, 2.0))


def test_log1mexp_is_accurate_at_both_ends():
    for log_p in (-1e-15, -1e-3, -0.5, -1.0, -30.0):
        expected = math.log(-math.expm1(log_p))
        got = float(log1mexp(torch.tensor(log_p, dtype=torch.float64)))
        assert got == pytest.approx(expected, rel=1e-12)


def test_log1mexp_has_a_finite_gradient():
    log_p = torch.tensor([-1e-9, -0.3, -50.0], dtype=torch.float64, requires_grad=True)
    log1mexp(log_p).sum().backward()
    assert torch.isfinite(log_p.grad).all()


def test_log1mexp_of_a_certainty_has_no_slope():
    log_p = torch.tensor([0.0, -1.0], dtype=torch.float64, requires_grad=True)
    log_q = log1mexp(log_p)
    log_q.clamp_min(LEAST_LOG).sum().backward()
    assert float(log_q.detach()[0]) == -math.inf
    assert float(log_p.grad[0]) == 0
    assert float(log_p.grad[1]) < 0
