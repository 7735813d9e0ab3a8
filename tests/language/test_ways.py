"""A street can be a way: up and down the street from a place are near it, in no direction."""

from __future__ import annotations

import pytest
from reading_cases import cases, faults


@pytest.mark.parametrize("case", cases("ways"), ids=lambda case: case.text)
def test_a_way_is_no_compass_word(case):
    assert faults(case) == []
