"""What one phrase says of the cells, with its frame summed out or given."""

from __future__ import annotations

from sloop_ppl.inference._phrase_tables import PhraseTables
from sloop_ppl.models import program_data
from sloop_ppl.models.program import summed_phrase

__all__ = ["log_phrase", "log_phrase_given_frame"]


def data_of(term, city, model):
    return program_data({"T": (term,)}, city, model)


def log_phrase(term, city, model):
    """Return the log of the phrase's factor, frame and lapse summed out, shape (S,)."""
    table = summed_phrase(data_of(term, city, model), model.likelihood, term).log_phi
    assert table.shape == (city.grid.size,)
    return table


def log_phrase_given_frame(term, city, model, frame_angles_rad):
    """Return the same for each of B fronts of the ground, shape (B, S)."""
    tables = PhraseTables(data_of(term, city, model), term)
    return tables.log_phi_given_frame(frame_angles_rad).expand(
        len(frame_angles_rad), city.grid.size
    )
