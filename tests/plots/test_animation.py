from __future__ import annotations

import stat
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image
from plots_fakes import FakeEpisode, blob, short_search

from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.maps import CityMap
from sloop_ppl.plots import animate_search
from sloop_ppl.plots._palette import ACCENTS
from sloop_ppl.plots.animation import _over, _Scene


def with_beliefs(city: CityMap) -> FakeEpisode:
    beliefs = tuple(
        {"Cup": blob(city, 2.5, 2.5, 20.0 - 3 * i), "Hat": blob(city, 60, -60, 15.0)}
        for i in range(6)
    )
    return short_search(city, beliefs=beliefs)


def test_one_frame_a_pose_and_the_last_one_stays(cleveland: CityMap, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    path = animate_search(
        with_beliefs(cleveland),
        cleveland,
        tmp_path / "s.gif",
        fps=5,
        progress=lambda done, of: seen.append((done, of)),
    )
    with Image.open(path) as film:
        assert film.n_frames == 6
        lengths = []
        for i in range(film.n_frames):
            film.seek(i)
            lengths.append(film.info["duration"])
    assert lengths == [200] * 5 + [2000]
    assert seen == [(i, 6) for i in range(1, 7)]
    assert path.stat().st_size < 600_000


def test_equal_input_gives_equal_bytes(cleveland: CityMap, tmp_path: Path) -> None:
    episode = with_beliefs(cleveland)
    one, other = (
        animate_search(episode, cleveland, tmp_path / name).read_bytes()
        for name in ("a.gif", "b.gif")
    )
    assert one == other


def test_the_robot_is_drawn_where_it_is_and_the_names_stay(cleveland: CityMap) -> None:
    episode = short_search(cleveland)
    scene = _Scene(episode, cleveland, [], ())
    frames = [np.asarray(scene.frame(i)).astype(int) for i in (0, 3)]
    height = scene.figure.bbox.height
    blue = 255 * np.array(to_rgb(ACCENTS["path"]))
    for frame, step in zip(frames, (0, 3), strict=True):
        x, y = scene.ax.transData.transform(episode.poses[step][:2])
        assert np.abs(frame[int(height - y), int(x)] - blue).max() < 12
    (label,) = (
        p for p in scene.labels.place(scene.canvas.get_renderer()) if p.label.text == "Stone Block"
    )
    west, south, east, north = (int(v) for v in label.box.bounds)
    rows, cols = slice(int(height) - north, int(height) - south), slice(west, east)
    assert (frames[0][rows, cols] == frames[1][rows, cols]).all()
    assert frames[0][rows, cols].min() < 120


def test_what_happened_is_told_step_by_step(cleveland: CityMap) -> None:
    scene = _Scene(short_search(cleveland), cleveland, [], ())
    assert [(scene._headline(i), scene._caption(i)) for i in range(6)] == [
        ("Step 0 of 5: start", "Looking for Cup, Hat"),
        ("Step 1 of 5: forward", "sees nothing, reward −10"),
        ("Step 2 of 5: find", "nothing found here, sees nothing, reward −1000"),
        ("Step 3 of 5: forward", "sees Cup, reward −10"),
        ("Step 4 of 5: turn left", "sees Cup, reward −10"),
        ("Step 5 of 5: find", "found Cup, sees Cup, reward +1000"),
    ]


def test_one_belief_that_stays_will_do(cleveland: CityMap, tmp_path: Path) -> None:
    belief = {"Cup": blob(cleveland, 0, 0, 10)}
    path = animate_search(short_search(cleveland), cleveland, tmp_path / "s.gif", beliefs=belief)
    assert path.exists()


def test_images_lie_over_each_other() -> None:
    red, clear = np.array([[[1.0, 0, 0, 0.5]]]), np.zeros((1, 1, 4))
    blue = np.array([[[0.0, 0, 1, 1.0]]])
    assert _over(red, blue)[0, 0].tolist() == [0.5, 0.0, 0.5, 1.0]
    assert _over(clear, blue)[0, 0].tolist() == [0, 0, 1, 1]
    assert _over(clear, clear)[0, 0].tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize(
    ("name", "more", "message"),
    [
        ("s.png", {}, "has the ending '.png'; expected one of .gif, .mp4"),
        ("s.gif", {"fps": 0}, "fps is 0; expected a positive number of frames a second"),
        (
            "s.gif",
            {"beliefs": [{}, {}]},
            "2 beliefs for 6 poses; expected one for each pose, or one mapping that stays",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(
    cleveland: CityMap, tmp_path: Path, name: str, more: dict, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        animate_search(short_search(cleveland), cleveland, tmp_path / name, **more)
    assert str(caught.value).endswith(message)
    assert list(tmp_path.iterdir()) == []


def test_an_mp4_without_ffmpeg_is_refused_before_the_work(
    cleveland: CityMap, tmp_path: Path
) -> None:
    with (
        mpl.rc_context({"animation.ffmpeg_path": "no-such-ffmpeg"}),
        pytest.raises(InputError) as caught,
    ):
        animate_search(short_search(cleveland), cleveland, tmp_path / "s.mp4")
    assert str(caught.value) == (
        "An .mp4 animation needs the program ffmpeg, which was not found; install it or choose an "
        "animation path that ends in .gif"
    )


def pretend_ffmpeg(folder: Path, body: str) -> str:
    """Write a program that stands in for ffmpeg."""
    program = folder / "ffmpeg"
    program.write_text(f"#!{sys.executable}\nimport sys\nraw = sys.stdin.buffer.read()\n{body}\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return str(program)


def test_an_mp4_is_piped_through_ffmpeg(cleveland: CityMap, tmp_path: Path) -> None:
    body = "open(sys.argv[-1], 'w').write(f'{len(raw)} {sys.argv[sys.argv.index(\"-s\") + 1]}')"
    program = pretend_ffmpeg(tmp_path, body)
    with mpl.rc_context({"animation.ffmpeg_path": program}):
        path = animate_search(short_search(cleveland), cleveland, tmp_path / "s.mp4")
    count, size = path.read_text().split()
    width, height = map(int, size.split("x"))
    assert width % 2 == height % 2 == 0
    assert int(count) == 6 * 3 * width * height


def test_what_ffmpeg_complains_of_is_passed_on(cleveland: CityMap, tmp_path: Path) -> None:
    program = pretend_ffmpeg(tmp_path, "sys.exit('first\\nno such codec')")
    with (
        mpl.rc_context({"animation.ffmpeg_path": program}),
        pytest.raises(OutputError, match="cannot be written; ffmpeg said: no such codec"),
    ):
        animate_search(short_search(cleveland), cleveland, tmp_path / "s.mp4")
