from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.plots import animation_formats, check_figure_path, figure_formats, save_figure


def test_the_formats_are_named() -> None:
    assert figure_formats() == ("jpg", "pdf", "png", "svg")
    assert animation_formats() == ("gif", "mp4")


@pytest.mark.parametrize("ending", figure_formats())
def test_every_format_can_be_written(tmp_path: Path, ending: str) -> None:
    figure = Figure(figsize=(1, 1))
    figure.add_subplot()
    assert save_figure(figure, tmp_path / f"x.{ending.upper()}").stat().st_size > 0


@pytest.mark.parametrize(
    ("name", "animation", "message"),
    [
        (
            "map.bmp",
            False,
            "Figure path 'map.bmp' has the ending '.bmp'; expected one of .jpg, .pdf, .png, .svg",
        ),
        (
            "map",
            False,
            "Figure path 'map' has no ending; expected one of .jpg, .pdf, .png, .svg",
        ),
        (
            "search.png",
            True,
            "Animation path 'search.png' has the ending '.png'; expected one of .gif, .mp4",
        ),
    ],
)
def test_an_unknown_ending_names_the_known_ones(name: str, animation: bool, message: str) -> None:
    with pytest.raises(InputError) as caught:
        check_figure_path(name, animation=animation)
    assert str(caught.value) == message


def test_a_missing_folder_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"folder .* does not exist; make it first"):
        check_figure_path(tmp_path / "no" / "map.png")
    (tmp_path / "x.png").mkdir()
    with pytest.raises(OutputError, match="is a folder; give the name of a file"):
        check_figure_path(tmp_path / "x.png")


def test_a_figure_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    from matplotlib.text import Text

    class Broken(Text):
        def draw(self, renderer: object) -> None:
            raise OSError(28, "No space left on device")

    path = tmp_path / "map.png"
    path.write_text("old")
    figure = Figure(figsize=(1, 1))
    figure.add_artist(Broken(0, 0, "x"))
    with pytest.raises(OutputError, match="cannot be written: No space left on device"):
        save_figure(figure, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
