"""Cues that deny: what is nowhere near, no longer at, anywhere but a place is not there."""

from __future__ import annotations

import pytest
from said import faults, sentences


@pytest.mark.parametrize("said", sentences("denied_cues"), ids=lambda said: said.text)
def test_what_is_denied_is_read_as_denied(said):
    assert faults(said) == []
