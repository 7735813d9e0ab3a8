"""Cues that deny: what is nowhere near, no longer at, anywhere but a place is not there."""

from __future__ import annotations

import pytest
from reading_cases import cases, faults


@pytest.mark.parametrize("case", cases("denied_cues"), ids=lambda case: case.text)
def test_what_is_denied_is_read_as_denied(case):
    assert faults(case) == []
