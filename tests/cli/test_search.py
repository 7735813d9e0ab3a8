"""`sloop search`: saved posteriors, words on the way, replays, explanations, Ctrl-C."""

from __future__ import annotations

import json
import signal

import pytest

from sloop_ppl.cli import main

TEXT = "the green toyota is behind velvet dog"
SEARCH = ["search", TEXT, "--map", "cleveland", "--planner", "greedy",
          "--place", "GreenToyota=-37.5,-72.5", "--start", "-22.5,-62.5,180"]  # fmt: skip


def run(capsys, *arguments, code=0):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


def refused(capsys, *arguments):
    out, err = run(capsys, *arguments, code=2)
    assert out == ""
    assert err.count("\n") == 1, err
    return err


@pytest.fixture
def saved(tmp_path, capsys):
    path = tmp_path / "p.nc"
    run(capsys, "infer", TEXT, "--map", "cleveland", "--out", path)
    return path


def test_a_search_goes_on_from_a_saved_posterior(saved, capsys):
    from_file, _ = run(capsys, "search", "--posterior", saved, *SEARCH[4:], "--json")
    anew, _ = run(capsys, *SEARCH, "--json")
    assert json.loads(from_file) == json.loads(anew)
    more, _ = run(capsys, "search", "it is near the hat factory", "--posterior", saved,
                  "--map", "cleveland", *SEARCH[4:], "--steps", "3", "--json")  # fmt: skip
    assert list(json.loads(more)["places"]) == ["GreenToyota"]


def test_words_on_the_way_are_told_and_kept(tmp_path, capsys):
    out = tmp_path / "e.json"
    _, err = run(capsys, *SEARCH[:-1], "80,80", "--steps", "3", "--out", out,
                 "--say", "1=it is near the hat factory", "--say", "100=it is near velvet dog",
                 "--say", "0=it is south of velvet dog")  # fmt: skip
    note, *lines = err.splitlines()
    assert note == (
        "100% of the belief of GreenToyota cannot be brought into view within 3 steps from this "
        "start: allow more steps, or start elsewhere"
    )
    assert lines[1] == "     told: “it is near the hat factory”"
    assert lines[-1] == "never said, for the search ended after 3 steps: “it is near velvet dog”"
    told = json.loads(out.read_text())
    assert told["said"] == {"0": "it is south of velvet dog", "1": "it is near the hat factory"}
    assert told["map"] == "cleveland"
    assert told["model"] == "bayes"
    again, _ = run(capsys, "search", "--replay", out, "--json")
    assert json.loads(again)["said"] == told["said"]


@pytest.mark.parametrize("planner", ["greedy", "random"])
def test_settings_of_simulations_are_said_to_go_unused(capsys, planner):
    short = [*SEARCH, "--steps", "1", "--planner", planner]
    _, err = run(capsys, *short, "--sims", "50", "--rollout", "published")
    assert [line for line in err.splitlines() if line.startswith("note:")] == [
        f"note: planner '{planner}' runs no simulations, so --{name} is not used"
        for name in ("sims", "rollout")
    ]
    _, err = run(capsys, *short)
    assert "note:" not in err


def test_an_explanation_marks_what_was_chosen(capsys):
    _, err = run(capsys, *SEARCH, "--planner", "fast", "--sims", "50", "--steps", "2", "--explain")
    why = [line for line in err.splitlines() if "expects to see GreenToyota" in line]
    assert len(why) >= 6
    assert any(line.startswith("     > ") and "value" in line for line in why)


def test_one_at_a_time(capsys):
    out, _ = run(
        capsys, "search", "the green toyota is near velvet dog, the red bike is on West 4th Street",
        "--map", "cleveland", "--planner", "random", "--one-at-a-time", "--steps", "2", "--json",
    )  # fmt: skip
    told = json.loads(out)
    assert told["steps"] == 4
    assert all(seen["RedBike"] is None for seen in told["observations"][:2])


@pytest.mark.slow
def test_a_saved_episode_is_drawn_again(tmp_path, capsys):
    episode = tmp_path / "e.json"
    first, again = tmp_path / "a.png", tmp_path / "b.png"
    film, refilm = tmp_path / "a.gif", tmp_path / "b.gif"
    said, _ = run(capsys, *SEARCH, "--steps", "3", "--out", episode, "--figure", first,
                  "--animation", film, "--json")  # fmt: skip
    resaid, _ = run(capsys, "search", "--replay", episode, "--figure", again, "--animation", refilm,
                    "--json")  # fmt: skip
    assert resaid == said
    line, _ = run(capsys, "search", "--replay", episode)
    assert line.startswith("found nothing in 3 steps, discounted reward -28.5; not found: ")
    assert first.read_bytes() == again.read_bytes()
    assert film.read_bytes() == refilm.read_bytes()


@pytest.fixture
def heeds_ctrl_c():
    """Let Ctrl-C interrupt: what a shell starts in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeds_ctrl_c")
@pytest.mark.parametrize("stop", ["Ctrl-C", "SIGTERM"])
def test_a_stopped_search_leaves_what_was_done(tmp_path, capsys, monkeypatch, stop):
    import sloop_ppl.bridge._search_request as search_request

    tell, told = search_request.step_line, []

    def interrupt(step):
        told.append(tell(step))
        if len(told) == 2:
            signal.raise_signal(signal.SIGINT if stop == "Ctrl-C" else signal.SIGTERM)
        return told[-1]

    monkeypatch.setattr(search_request, "step_line", interrupt)
    episode, figure = tmp_path / "e.json", tmp_path / "f.png"
    code, before = (130 if stop == "Ctrl-C" else 143), signal.getsignal(signal.SIGTERM)
    out, err = run(capsys, *SEARCH, "--out", episode, "--figure", figure, code=code)
    assert out == ""
    assert err.endswith("sloop: stopped\n")
    assert signal.getsignal(signal.SIGTERM) is before
    document = json.loads(episode.read_text())
    assert document["steps"] == len(document["actions"]) == len(document["poses"]) - 1 == 2
    assert figure.read_bytes().startswith(b"\x89PNG")
    line, _ = run(capsys, "search", "--replay", episode)
    assert "in 2 steps" in line


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--say", "later=it is near velvet dog"], "expected STEP=TEXT"),
        (["--say", "3="], "expected STEP=TEXT"),
        (["--say", "-1=it is near velvet dog"], "expected a step of at least 0"),
        (["--say", "3=near", "--say", "3=far"], "step 3 are given twice"),
        (["--say", "3=what a lovely day"], "No relation"),
        (["--posterior", "absent.nc"], "'absent.nc' cannot be read"),
        (["--posterior", "absent.nc", "--model", "sloop"], "--model does not go with --posterior"),
        (["--replay", "absent.json"], "TEXT does not go with --replay"),
        (["--rollout", "best"], "Rollout 'best' is unknown"),
        (["--set", "no_fli=true"], "Setting 'no_fli' is unknown"),
        (["--set", "no_fly"], "expected NAME=VALUE"),
        (["--set", "no_fly=perhaps"], "'perhaps'; expected true or false"),
        (["--set", "turn_deg=4.5"], "'4.5'; expected a whole number"),
        (["--set", "turn_deg=60"], "expected 45 or 90"),
        (["--set", "discount=high"], "'high'; expected a number"),
        (["--set", "sims=3"], "has an option of its own; give --sims"),
        (["--set", "no_fly=1", "--set", "no_fly=0"], "is given twice"),
        (["--set", "no_fly=true", "--start", "80,80"], "inside a no-fly building"),
        (["--set", "false_positive_rate=1"], "expected a number in [0, 1)"),
        (["--tree", "t.json", "--planner", "greedy"], "grows no tree"),
        (["--tree", "t.txt"], "expected one of .json"),
        (["--tree-step", "1"], "say where it goes with --tree"),
        (["--tree", "t.json", "--tree-step", "0"], "expected at least 1"),
        (["--posterior-out", "p.txt"], "expected one of .nc"),
        (["--sims", "0"], "sims is 0; expected a whole number of at least 1"),
        (["--sims", "-3"], "sims is -3; expected a whole number of at least 1"),
        (["--place", "GreenToyota=900,0"], "outside"),
        (["--place", "GreenToyota=41.4998N,-81.6995"], "expected OBJECT=x,y in metres"),
        (["--place", "GreenToyota=@41.4993,-81.6944"], "latitude in [41.49956, 41.50136]"),
        (["--place", "GreenToyota=@-81.6995,41.4998"], "expected the latitude first"),
        (["--start", "@41.4998,-81.6995,20"], "expected a multiple of 45 degrees"),
        (["--start", "@41.4998,-81.6995,east"], "or the point as @LAT,LON"),
        (["--hearer", "@-81.6995,41.4998"], "expected the latitude first"),
        (["--area=-81.7,41.4997,-81.698,41.501"], "or the text @-81.7,41.4997,-81.698,41.501"),
        (["--area=@-81.7,41.4997,-81.698,91"], "is not on earth"),
        (["--range", "0.5"], "sensor_range_cells is 0.5"),
    ],
)
def test_mistakes(options, said, capsys):
    assert said in refused(capsys, *SEARCH[:4], *options)


DEGREES = {
    "--place": "GreenToyota=@41.49980532,-81.69951382",
    "--start": "41.499896N,81.699334W,180",
}


def test_degrees_are_the_metres_that_they_stand_for(capsys):
    metres = json.loads(run(capsys, *SEARCH, "--json")[0])
    place, start = "GreenToyota=@41.49980532,-81.69951382", "41.499896N,81.699334W,180"
    out, err = run(capsys, *SEARCH[:6], "--place", place, "--start", start, "--json")
    degrees = json.loads(out)
    assert degrees["poses"] == metres["poses"]
    assert degrees["observations"] == metres["observations"]
    assert degrees["places"]["GreenToyota"] == pytest.approx([-37.5, -72.5], abs=0.01)
    assert "note" not in err


def test_metres_that_would_be_degrees_of_the_map_are_questioned(capsys):
    typed = ["--place", "GreenToyota=41.4998,-81.6995", "--start=-81.6995,41.4998"]
    out, err = run(capsys, *SEARCH[:6], *typed, "--steps", "1", "--json")
    assert json.loads(out)["places"] == {"GreenToyota": [41.4998, -81.6995]}
    assert err.splitlines()[:2] == [
        (
            f"note: {written} was read as metres from the map's centre; are these degrees? If so, "
            "write @41.4998,-81.6995"
        )
        for written in ("--place GreenToyota=41.4998,-81.6995", "--start -81.6995,41.4998")
    ]


def test_a_text_and_a_map_are_asked_for(capsys):
    assert "Missing argument 'TEXT'" in refused(capsys, "search", "--map", "cleveland")
    assert "Missing option '--map'" in refused(capsys, "search", TEXT)


def test_other_maps_are_refused(saved, tmp_path, capsys):
    line = refused(capsys, "search", "--posterior", saved, "--map", "austin")
    assert "was made on another map ('cleveland'); expected 'austin'" in line
    episode = tmp_path / "e.json"
    run(capsys, *SEARCH, "--steps", "1", "--out", episode)
    line = refused(capsys, "search", "--replay", episode, "--map", "austin")
    assert "searched on another map ('cleveland', (41, 41) cells); found 'austin'" in line
    document = json.loads(episode.read_text())
    episode.write_text(json.dumps({**document, "version": 99}))
    assert "version 99" in refused(capsys, "search", "--replay", episode)
    episode.write_text(json.dumps({**document, "map": "mine"}))
    assert "give its file with --map" in refused(capsys, "search", "--replay", episode)
    episode.write_text(json.dumps({**document, "map_digest": "0" * 16}))
    assert "another version of map 'cleveland'" in refused(capsys, "search", "--replay", episode)


@pytest.mark.parametrize("planner", ["fast", "pouct", "pomcp"])
def test_the_tree_of_a_decision_is_saved(planner, tmp_path, capsys):
    path = tmp_path / "t.json"
    more = ["--planner", planner, "--sims", "60", "--steps", "3", "--tree", path]
    run(capsys, *SEARCH[:-1], "80,80", *more)
    last = json.loads(path.read_text())
    assert (last["planner"], last["step"]) == (planner, 3)
    run(capsys, *SEARCH[:-1], "80,80", *more, "--tree-step", "2", "--set", "tree_depth=1")
    told = json.loads(path.read_text())
    assert told["step"] == 2
    assert told["action"] in told["tree"]["actions"]
    assert told["tree"]["visits"] >= 50
    for branch in told["tree"]["actions"].values():
        assert all(after["actions"] == {} for after in branch["after"].values())
    line = refused_in_the_end(capsys, *SEARCH[:-1], "80,80", *more, "--tree-step", "9")
    assert line.startswith("sloop: Step 9 was decided by a tree, in 3 steps")


def refused_in_the_end(capsys, *arguments):
    _, err = run(capsys, *arguments, code=2)
    return err.splitlines()[-1]


def test_what_is_believed_after_a_search_is_saved_and_gone_on_from(tmp_path, capsys):
    path, said = tmp_path / "p.nc", ["--say", "1=it is near velvet dog", "--json", "--steps"]
    begin = [*SEARCH[:-1], "40,40"]
    first, _ = run(capsys, *begin, *said, 2, "--posterior-out", path)
    x, y, heading = json.loads(first)["poses"][-1]
    on = ["--start", f"{x},{y},{heading:g}", "--json", "--steps", 6]
    rest, _ = run(capsys, "search", "--posterior", path, *begin[4:-2], *on)
    whole, _ = run(capsys, *begin, *said, 8)
    told = [json.loads(text)["poses"] for text in (first, rest, whole)]
    assert told[0] + told[1][1:] == told[2]


def test_up_and_down_are_no_compass_words_from_the_ground(capsys):
    above = [
        "search",
        "the green toyota is above velvet dog",
        *SEARCH[2:],
        "--steps",
        "4",
        "--json",
    ]
    from_a_map, _ = run(capsys, *above)
    from_the_ground, _ = run(capsys, *above, "--viewpoint", "ground")
    assert json.loads(from_a_map)["actions"] != json.loads(from_the_ground)["actions"]
