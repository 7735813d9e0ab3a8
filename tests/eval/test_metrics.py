"""Measures of a belief, on beliefs that are solved by hand, of the map and of an area."""

import json
import math

import numpy as np
import pytest

from sloop_ppl.cli import main
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import METRICS, bundled_examples, read_descriptions, score_beliefs
from sloop_ppl.eval._belief_scores import score_belief
from sloop_ppl.eval._quality_report import quality_tables
from sloop_ppl.eval._user_metrics import metrics_with
from sloop_ppl.eval.descriptions import Place
from sloop_ppl.eval.metrics import summarised
from sloop_ppl.maps import Grid, search_area
from sloop_ppl.models import preset

GRID = Grid(0, 0, 10, 10, cell_m=5.0)  # 3 x 3 cells
BELIEF = np.array([[0.5, 0.2, 0.1], [0.1, 0.1, 0.0], [0.0, 0.0, 0.0]])


def place(row, col, area=None):
    return Place(float(GRID.x_m[col]), float(GRID.y_m[row]), (row, col), area)


def measured(truth, belief=BELIEF):
    return {name: measure(belief, GRID, truth) for name, measure in METRICS.items()}


def test_the_metrics_by_hand():
    found = measured(place(0, 1))
    assert found["log_score"] == pytest.approx(math.log(0.2))
    assert found["mean_log_score_mixed"] == pytest.approx(math.log(0.99 * 0.2 + 0.01 / 9))
    assert found["rank"] == 1
    assert found["mapscore"] == pytest.approx(1 - 2 * 1 / 8)  # one of eight others comes before
    assert found["median_error_m"] == pytest.approx(5)
    expected = 0.5 * 5 + 0.1 * 5 + 0.1 * math.hypot(5, 5) + 0.1 * 5
    assert found["expected_distance_m"] == pytest.approx(expected)
    assert found["poa_25m"] == pytest.approx(1)


def test_best_worst_and_uniform():
    assert measured(place(0, 0))["mapscore"] == 1
    last = np.where(np.arange(9).reshape(3, 3) == 8, 0.0, 1 / 8)
    assert measured(place(2, 2), last)["mapscore"] == -1
    uniform = measured(place(1, 1), np.full((3, 3), 1 / 9))
    assert uniform["mapscore"] == pytest.approx(0, abs=1e-12)
    assert uniform["rank"] == 4
    # No order of cells matters: the error is the mean over all that tie for the mode.
    assert uniform["median_error_m"] == pytest.approx((4 * 5 + 4 * math.hypot(5, 5)) / 9)


def test_ties_are_halved():
    # Two cells come before (0, 2), and of the two that tie with it one.
    assert measured(place(0, 2))["mapscore"] == pytest.approx(1 - 2 * 3 / 8)


def test_probability_of_area():
    grid = Grid.square(200, cell_m=5.0)
    belief = np.zeros(grid.shape)
    row, col = grid.cell_at(0.0, 0.0)
    for cells_off, mass in ((0, 0.1), (5, 0.2), (6, 0.15), (10, 0.25), (20, 0.1), (21, 0.2)):
        belief[row, col + cells_off] = mass
    truth = Place(*grid.centre_of(row, col), (row, col))
    found = [METRICS[f"poa_{d}m"](belief, grid, truth) for d in (25, 50, 100)]
    assert found == pytest.approx([0.3, 0.7, 0.8])


def test_an_area_is_all_there_is():
    area = np.zeros((3, 3), dtype=bool)
    area[0] = True
    belief = np.where(area, BELIEF, 0) / 0.8
    found = measured(place(0, 2, area), belief)
    assert found["mean_log_score_mixed"] == pytest.approx(math.log(0.99 * 0.125 + 0.01 / 3))
    assert found["mapscore"] == -1
    assert found["rank"] == 2
    uniform = measured(place(0, 1, area), np.where(area, 1 / 3, 0))
    assert uniform["log_score"] == pytest.approx(-math.log(3))
    assert uniform["mapscore"] == 0
    # Cells outside tie with a true cell that is held impossible, and are not counted.
    impossible = np.where(area, [0.6, 0.4, 0.0], 0)
    assert measured(place(0, 2, area), impossible)["rank"] == 2
    only = np.zeros((3, 3), dtype=bool)
    only[1, 1] = True
    assert measured(place(1, 1, only), only.astype(float))["mapscore"] == 1
    most = score_belief(np.where(area, 1 / 3, 0), GRID, place(0, 1, area)).regions[1]
    assert (most.covers, most.area_m2) == (pytest.approx(0.9), pytest.approx(0.9 * 3 * 25))


def test_a_median_is_taken_of_what_is_called_so():
    assert summarised("rank", [0, 0, 9]) == 0
    assert summarised("median_error_m", [1, 2, 9]) == 2
    assert summarised("mapscore", [0, 0, 9]) == 3


def test_a_place_by_the_border_counts_in_the_nearest_cell():
    area = search_area((0, 5, 3, 11), GRID)  # holds the centre of one column alone
    assert area.cells.astype(int).tolist() == [[0, 0, 0], [0, 0, 0], [1, 0, 0]]
    inside = Place(1.0, 6.0, GRID.cell_at(1.0, 6.0)).within(area, GRID)
    assert inside.cell == (2, 0)
    beside = Place(5.5, 9.0, GRID.cell_at(5.5, 9.0)).within(area, GRID)
    assert GRID.cell_at(5.5, 9.0) == (2, 1)
    assert beside.cell == (2, 0)


def line(key, area=None, configuration=None):
    return {
        "id": key, "map": "cleveland", "text": "the red bike is near Ivy",
        "configuration": configuration or key,
        "targets": {"RedBike": {"east_m": -72.0, "north_m": 42.0}},
        **({"area_m": area} if area else {}),
    }  # fmt: skip


@pytest.fixture
def files(tmp_path):
    for name, area in (("whole", None), ("part", [-100, -50, 0, 50])):
        lines = [json.dumps(line(f"{name}{i}", area)) for i in range(2)]
        (tmp_path / f"{name}.jsonl").write_text("\n".join(lines))
    return [tmp_path / "whole.jsonl", tmp_path / "part.jsonl"]


def run(capsys, code, *arguments):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


QUALITY = ("eval", "quality", "--parsed", "--models", "uniform,bayes")


def test_quality_is_of_the_area_and_told_file_by_file(files, capsys):
    out, _ = run(capsys, 0, *QUALITY, "--json", *files)
    told = json.loads(out)
    whole, part = told["sets"]["whole"]["models"], told["sets"]["part"]["models"]
    assert whole["uniform"]["mean_log_score"] == pytest.approx(-math.log(1681))
    assert part["uniform"]["mean_log_score"] == pytest.approx(-math.log(400))
    assert part["uniform"]["mean_log_score_mixed"] == pytest.approx(-math.log(400))
    both = told["models"]["uniform"]
    assert both["mean_log_score"] == pytest.approx(-(math.log(1681) + math.log(400)) / 2)
    assert (both["n"], part["uniform"]["n"]) == (4, 2)
    assert set(told["metrics"]) < set(both)
    for key in ("mapscore", "poa_25m", "poa_50m", "poa_100m", "median_error_m"):
        assert key in part["bayes"]
    assert part["bayes"]["mapscore"] > part["uniform"]["mapscore"] == 0
    assert "sets" not in json.loads(run(capsys, 0, *QUALITY, "--json", files[0])[0])
    tables = {table.name: table for table in quality_tables(told)}
    assert [row[:2] for row in tables["quality-sets"].rows] == [
        ("whole", "uniform"), ("whole", "bayes"), ("part", "uniform"), ("part", "bayes"),
    ]  # fmt: skip


def test_a_set_is_scored_as_if_alone(files):
    alone = score_beliefs(
        read_descriptions(files[1]), {"bayes": preset("bayes")}, relations="parsed",
        rng=np.random.default_rng(0),
    )  # fmt: skip
    among = score_beliefs(
        read_descriptions(files), {"bayes": preset("bayes")}, relations="parsed",
        rng=np.random.default_rng(0),
    )  # fmt: skip
    assert among.sets["part"].models == alone.models


def test_files_of_one_name_are_told_apart(files, tmp_path):
    (tmp_path / "other").mkdir()
    twin = tmp_path / "other" / "whole.jsonl"
    twin.write_text(json.dumps(line("third")))
    read = read_descriptions([files[0], twin])
    assert {one.source for one in read} == {str(tmp_path / "whole"), str(twin.with_suffix(""))}


def test_an_area_without_the_target_is_a_fault(tmp_path):
    path = tmp_path / "said.jsonl"
    path.write_text(json.dumps(line("far", [-50, -10, 50, 50])))
    with pytest.raises(InputError) as error:
        read_descriptions(path)
    assert str(error.value) == (
        f"{path}:1: field 'targets.RedBike' is at (-72, 42); expected a place in 'area_m', "
        "[-50.0, -10.0, 50.0, 50.0]"
    )


MINE = """
import numpy as np

three = 3


def peak(belief, grid, truth):
    return belief.max()


def median_of_column(belief, grid, truth):
    return truth.cell[1]


class Area:
    def __call__(self, belief, grid, truth):
        return grid.size if truth.area is None else truth.area.sum()


def rank(belief, grid, truth):
    return 0


def broken(belief, grid, truth):
    return 1 / 0


def wordy(belief, grid, truth):
    return "much"


def mean_of(belief):
    return belief.mean()
"""


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    return path


def test_metrics_of_ones_own(files, mine, capsys):
    own = [f"{mine}:{name}" for name in ("peak", "median_of_column", "Area")]
    options = [part for spec in own for part in ("--metric", spec)]
    told = json.loads(run(capsys, 0, *QUALITY, "--json", *options, *files)[0])
    one = told["sets"]["part"]["models"]["uniform"]
    assert one["peak"] == pytest.approx(1 / 400)
    assert one["Area"] == 400
    assert one["median_of_column"] == 5
    assert told["metrics"][-3:] == ["peak", "median_of_column", "Area"]
    out, _ = run(capsys, 0, *QUALITY, *options[:2], files[1])
    assert "peak" in out


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("rank", "Metric 'mine.py:rank' has a name that is taken ('rank')"),
        ("three", "Metric 'mine.py:three' is a int; expected a metric: a function"),
        ("broken", "Metric 'mine.py:broken' fails at line 25: ZeroDivisionError"),
        ("wordy", "Metric 'mine.py:wordy' returns 'much'; expected a finite number"),
        ("none", "Metric of mine.py 'none' is unknown"),
        (
            "mean_of",
            "Metric 'mine.py:mean_of' takes belief; expected three arguments: belief, grid, truth",
        ),
    ],
)
def test_bad_metrics_are_refused_in_one_line(files, mine, capsys, name, message):
    _, err = run(capsys, 2, *QUALITY, "--json", "--metric", f"{mine}:{name}", files[0])
    assert message in err.splitlines()[-1]


def test_a_registered_metric_is_measured(monkeypatch):
    monkeypatch.setattr(METRICS, "_entries", dict(METRICS._entries))
    METRICS.add("columns", lambda belief, grid, truth: belief.shape[1])
    found = score_beliefs(
        bundled_examples()[:1], {"uniform": preset("uniform")}, rng=np.random.default_rng(0)
    )
    assert found.models["uniform"].metrics["columns"] == 41
    assert "columns" in metrics_with([])
    with pytest.raises(UnknownName, match="Metric 'mapscor' is unknown"):
        METRICS["mapscor"]
