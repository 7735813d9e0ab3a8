"""A street can be a way: up and down the street from a place are near it, in no direction."""

from __future__ import annotations

import pytest
from said import faults, sentences


@pytest.mark.parametrize("said", sentences("ways"), ids=lambda said: said.text)
def test_a_way_is_no_compass_word(said):
    assert faults(said) == []
