"""What one phrase says of the cells, with its frame summed out or given."""

from __future__ import annotations

from sloop_ppl.inference._phrase_tables import PhraseTables
from sloop_ppl.models import program_data
from sloop_ppl.models.program import summed_phrase

__all__ = ["log_phrase", "log_phrase_given_front"]


def data_of(term, city, model):
    return program_data({"T": (term,)}, city, model)


def log_phrase(term, city, model):
    """Return the log of the phrase's factor, frame and lapse summed out, shape (S,)."""
    table = summed_phrase(data_of(term, city, model), model.likelihood, term).log_phi
    assert table.shape == (city.grid.size,)
    return table


def log_phrase_given_front(term, city, model, fronts_rad):
    """Return the same for each of B fronts of the ground, shape (B, S)."""
    tables = PhraseTables(data_of(term, city, model), term)
    return tables.log_phi_given_frame(fronts_rad).expand(len(fronts_rad), city.grid.size)
