"""The word of one's own in docs/language.md runs as it stands."""

import re
from pathlib import Path

import pytest

from sloop_ppl.language import RELATIONS

PAGE = (Path(__file__).parents[2] / "docs" / "language.md").read_text()
SECTION = PAGE.split("## A word of your own\n")[1].split("\n## ")[0]


def test_a_word_takes_less_than_twenty_five_lines_and_runs():
    (code,) = re.findall(r"```python\n(.*?)```", SECTION, re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) < 25
    names = {}
    try:
        exec(compile(code, "language.md", "exec"), names)
    finally:
        added = RELATIONS.remove("kitty-corner")
    belief = names["post"].belief("RedBike")
    assert belief.sum() == pytest.approx(1)
    (relation,) = names["post"].relations("RedBike")
    assert (relation.relation, relation.ground) == ("kitty-corner", "NorwoodTower")
    city = names["post"].city
    there = added.region(city, ("NorwoodTower",)).centroid
    mode = names["post"].mode("RedBike")
    assert abs(mode[0] - there.x) + abs(mode[1] - there.y) < 40
