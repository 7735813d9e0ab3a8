"""Flown trials: resumed, the same again, and summed up as by hand; the sweep over poses."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from importlib.util import find_spec

import numpy as np
import pytest
from shapely import Point

from sloop_ppl.errors import InputError
from sloop_ppl.eval import bundled_examples
from sloop_ppl.eval._camera_sweep import CameraScore, sweep_camera, sweep_figure, sweep_lines
from sloop_ppl.eval._flown import _chosen, fly_trials, read_flown
from sloop_ppl.eval._flown_report import flown_lines, flown_summary
from sloop_ppl.eval._flown_trial import ARMS, FlownTrial
from sloop_ppl.maps import load_map

TRIAL = FlownTrial(
    description="d", target="T", seed=0, arm="grid, 10 m", map="m", reachable=True, found=True,
    steps=10, discounted_reward=100.0, collisions=0, moves=6, in_view=4, detected=3,
    false_reports=0, looks=9, wrong_finds=0, time_s=0.0, lost=False,
)  # fmt: skip


@pytest.fixture
def _simulator():
    if find_spec("mujoco") is None:
        pytest.skip("the simulator needs mujoco")


def test_arms_are_summed_up_over_the_trials_that_all_of_them_have():
    flown = replace(TRIAL, arm="camera, 10 m", found=False, collisions=1, moves=8, time_s=40.0)
    trials = [
        TRIAL, flown,
        replace(TRIAL, seed=1), replace(flown, seed=1, found=True, collisions=0),
        replace(TRIAL, seed=2),  # of which the camera is not done
        replace(TRIAL, seed=3, reachable=False, found=False),
        replace(flown, seed=3, reachable=False),
    ]  # fmt: skip
    grid, camera = flown_summary(trials)
    assert (grid.n, camera.n, grid.out_of_reach) == (2, 2, 1)
    assert (grid.success, camera.success, camera.against_grid) == (1.0, 0.5, 0.5)
    assert (camera.collisions, camera.moves, camera.time_s) == (1, 16, 40.0)
    low, high = camera.collisions_ci95
    assert low == pytest.approx(1 - 0.975 ** (1 / 16), rel=1e-6)
    assert 0.2 < high < 0.35
    # None in 12 moves: 1 - 0.05 ** (1 / 12).
    assert grid.collisions_ci95 == (0.0, pytest.approx(1 - 0.05 ** (1 / 12)))
    assert grid.detection_rate == 0.75
    table = flown_lines([grid, camera])
    assert len(table) == 4
    assert "| camera, 10 m | 2 | 0.500" in table[3]
    assert json.dumps(camera.to_json())


@pytest.mark.usefixtures("_simulator")
def test_a_stopped_run_goes_on_where_it_was(tmp_path):
    arms = [a for a in ARMS if a.name in ("grid, 14 m", "rays, 14 m")]
    options = {"targets": 1, "seeds": 1, "sims": 50, "max_steps": 4}
    told: list[str] = []
    first = fly_trials(
        bundled_examples(), load_map, tmp_path, arms=arms[:1], notify=told.append, **options
    )
    both = fly_trials(
        bundled_examples(), load_map, tmp_path, arms=arms, notify=told.append, **options
    )
    assert len(told) == 2
    assert len(first) == 1
    assert {t.arm for t in both} == {"grid, 14 m", "rays, 14 m"}
    assert read_flown(tmp_path / "trials.jsonl") == sorted(both, key=lambda t: t.arm)
    again = fly_trials(
        bundled_examples(), load_map, tmp_path / "b", arms=arms, notify=told.append, **options
    )
    assert again == both
    with pytest.raises(InputError, match=r"other settings: sims.*Choose another folder"):
        fly_trials(
            bundled_examples(), load_map, tmp_path, arms=arms, notify=told.append,
            **{**options, "sims": 60},
        )  # fmt: skip


def test_damaged_trials_are_refused_and_a_torn_last_line_is_no_trial(tmp_path):
    whole = FlownTrial(
        "one", "RedBike", 0, "grid, 14 m", "cleveland", True, True, 4, 900.0, 0, 3, 1, 1, 0, 4, 0,
        0.0, False,
    )  # fmt: skip
    path = tmp_path / "trials.jsonl"
    assert read_flown(path) == []
    path.write_text(json.dumps(asdict(whole)) + '\n{"description": "tw')
    assert read_flown(path) == [whole]
    for line in (b'{"arm": 3}', b"[]", b"\xff", b'{"a":' * 200, b"NaN",
                 json.dumps(asdict(whole) | {"steps": "many"}).encode()):  # fmt: skip
        path.write_bytes(line + b"\n")
        with pytest.raises(InputError) as caught:
            read_flown(path)
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)


@pytest.mark.usefixtures("_simulator")
def test_what_was_left_is_done_as_in_one_go_by_any_number_of_processes(tmp_path):
    """A run that was stopped within an altitude, or after one, starts the others where it would."""
    arms = [a for a in ARMS if a.where in ("grid", "rays") and a.gust_m_s != 3.0]
    options = {"targets": 1, "seeds": 2, "sims": 20, "max_steps": 3, "notify": lambda _: None}
    whole = fly_trials(
        bundled_examples(), load_map, tmp_path / "a", arms=arms, workers=2, **options
    )
    assert len(whole) == 8
    assert {(t.seed, t.arm) for t in whole} == {(s, a.name) for s in (0, 1) for a in arms}
    lines = (tmp_path / "a" / "trials.jsonl").read_text().splitlines(keepends=True)
    kept = [line for line in lines if "14 m" in line and "grid" in line] + lines[-1:]
    (tmp_path / "a" / "trials.jsonl").write_text("".join(kept))
    again = fly_trials(
        bundled_examples(), load_map, tmp_path / "a", arms=arms, workers=1, **options
    )
    assert again == whole


def test_forty_targets_of_the_examples_have_room_and_something_said_of_them():
    told: list[str] = []
    chosen = _chosen(bundled_examples(), load_map, 40, 2, told.append)
    assert len({(t.annotated.id, t.target) for t in chosen}) == 40
    assert len(chosen) == 80
    assert len({t.annotated.map for t in chosen}) == 5
    assert [line.partition(" is left out: ")[0] for line in told] == [
        "honolulu-ex-03 RedHonda", "austin-ex-04 RedBike",
    ]  # fmt: skip
    for flown in chosen:
        built = [b.geometry for b in flown.city.of_kind("building")]
        place = Point(flown.place())
        assert min(place.distance(b) for b in built) > 1.49


@pytest.mark.usefixtures("_simulator")
def test_a_sweep_over_poses_counts_and_draws():
    city = load_map("cleveland")
    scores = sweep_camera([city], altitudes_m=(14.0,), detectors=("rays", "oracle"), poses=9)
    rays, oracle = scores
    assert rays.in_view == oracle.in_view > 3
    assert rays.in_view + rays.out_of_view == 9 * 6
    assert rays.by_distance[:, 0].sum() == rays.in_view
    assert len(rays.errors_m) == rays.detected
    assert np.median(rays.errors_m) < 1.0
    assert len(sweep_lines(scores)) == 3
    assert len(sweep_figure(scores).axes) == 2


def test_the_noise_of_a_detector_gives_its_share_of_wrong_cells():
    score = CameraScore("camera", 14.0, in_view=100, detected=90, wrong_cell=18, out_of_view=50)
    rates = score.rates()
    assert rates.true_positive == 0.9
    assert rates.false_positive == 0.0
    weight = np.exp(-1 / (2 * rates.position_noise_cells**2))
    assert 4 * weight / (1 + 4 * weight) == pytest.approx(0.2, abs=0.02)
