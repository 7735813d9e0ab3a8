"""The Python of docs/frames.md runs and says what the page says."""

import math
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "frames.md").read_text(encoding="utf-8")


def test_the_python_of_the_page_runs():
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    told: dict = {}
    exec(code, told)  # the page's own code
    first, second = told["front"].parts[:2]
    gap = abs(math.remainder(first.mean_rad - second.mean_rad, 2 * math.pi))
    assert 1.2 < gap < 1.9  # a corner house faces either of two streets


def test_every_predictor_and_prior_is_described():
    from sloop_ppl.models import FRAME_PREDICTORS, FRAME_PRIORS

    for name in (*FRAME_PREDICTORS, *FRAME_PRIORS):
        assert f"`{name}`" in PAGE


def test_no_place_is_left_to_be_filled_in():
    card = (ROOT / "sloop_ppl" / "data" / "frames" / "MODEL_CARD.md").read_text(encoding="utf-8")
    assert "@" not in PAGE + card
