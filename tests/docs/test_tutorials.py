"""The Python of the tutorials runs as it stands, and what they say is so."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path

import pytest

from sloop_ppl.cli import main
from sloop_ppl.inference import ENGINES

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "your_own_likelihood.md").read_text()


def blocks(kind):
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


def test_the_likelihood_takes_at_most_twenty_lines():
    code = next(code for code in blocks("python") if code.startswith("# mine.py\n"))
    lines = [line for line in code.splitlines()[1:] if line.strip()]
    assert len(lines) <= 20


@pytest.mark.slow
def test_the_page_on_likelihoods_runs(run_page, tmp_path, capsys):
    run_page(DOCS / "your_own_likelihood.md")
    out = capsys.readouterr().out
    assert "log_g of Cardioid for relation 'on' of an area is 5.9 at its highest; expected" in out
    rows = dict(re.findall(r"^\| (\w+) \| (\S+) \|", out, re.MULTILINE))
    for engine in ENGINES:
        assert 0 <= float(rows[engine]) < 0.2
    scores = re.findall(r"^(\w+) +(-\d\.\d\d) \(", out, re.MULTILINE)
    assert [name for name, _ in scores] == ["paper", "cardioid", "bayes"]
    assert all(float(score) > -7.43 for _, score in scores)
    assert (tmp_path / "compared.png").stat().st_size > 30_000


def test_the_way_from_descriptions_to_numbers(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (mine,) = [code for code in blocks("python") if code.startswith("# mine.py\n")]
    (tmp_path / "mine.py").write_text(mine)
    section = PAGE.split("## Fit it to descriptions")[1].split("\n## ")[0]
    notes, names = [], {}
    for kind, code in re.findall(r"```(python|)\n(.*?)```", section, re.DOTALL):
        if kind:
            exec(compile(code, "your_own_likelihood.md, fitting", "exec"), names)
            continue
        for line in code.splitlines():
            with pytest.raises(SystemExit) as done:
                main(shlex.split(line)[1:])
            out, err = capsys.readouterr()
            assert done.value.code in (0, None), err
            notes += [told for told in err.splitlines() if told.startswith("note: ")]
            assert out
    assert notes == []  # it is fitted, or --params sets what was borrowed
    told = json.loads((tmp_path / "mine.json").read_text())
    assert set(told["parameters"]) == {"likelihood", "model", "frames", "weights"}
    assert told["provenance"]["selection"]["winner"] == "mine.py:Cardioid"
    assert not (tmp_path / "mine.fits").exists()
    # The command's last fit is the one that Python makes of the same examples.
    for section, numbers in json.loads((tmp_path / "all.json").read_text())["parameters"].items():
        for name, value in numbers.items():
            assert told["parameters"][section][name] == pytest.approx(value, rel=1e-3)
    assert capsys.readouterr().out.startswith("note: lapse, own_lapse, temper, kappa, absolute")


def test_the_parameters_of_the_page_are_some():
    from sloop_ppl.models import preset
    from sloop_ppl.models.tuning import with_parameters

    (text,) = blocks("toml")
    told = tomllib.loads(text)
    assert told.pop("likelihood") == {"reach_m": 22.5}
    assert with_parameters(preset("bayes"), told).lapse == 0.05


def test_every_link_of_the_page_leads_somewhere():
    links = re.findall(r"\]\((?!http)([^)]+)\)", PAGE)
    assert len(links) == 5
    files = [link.partition("#")[0] for link in links]
    assert [file for file in files if not (DOCS / file).exists()] == []
