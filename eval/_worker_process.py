"""What a worker process does before and after a job: threads, Ctrl-C, models by value."""

from __future__ import annotations

import pickle
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache

import cloudpickle
import torch

from sloop_ppl.models import ObservationModel

__all__ = ["one_thread", "pickled_model", "unpickled_model"]


def pickled_model(model: ObservationModel) -> bytes:
    """Return a model as bytes that any process can read, a user's own included."""
    for name, module in list(sys.modules.items()):
        if name.startswith("_sloop_user_"):  # as models.user calls a user's file
            cloudpickle.register_pickle_by_value(module)
    pickled: bytes = cloudpickle.dumps(model)
    return pickled


@lru_cache(maxsize=64)
def unpickled_model(pickled: bytes) -> ObservationModel:
    """Return a model that was pickled by value; the same object for the same bytes."""
    model: ObservationModel = pickle.loads(pickled)
    return model


@contextmanager
def one_thread(*, stoppable: bool) -> Iterator[None]:
    """Use one thread; a worker leaves Ctrl-C to the driver."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    if not stoppable:
        with suppress(ValueError):
            signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        torch.set_num_threads(before)
