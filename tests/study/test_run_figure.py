"""The figure of a run is drawn from its folder alone, whatever the run's length."""

import cv2
import numpy as np
import pytest

from deformpush.experiment.recorder import Recorder
from deformpush.record.folder import RunFolder
from deformpush.study import run_figure as figures


def record(path, run, pushes) -> RunFolder:
    info, rows = run
    folder = RunFolder.create(path, "")
    with Recorder(folder, rrd=False, figures=False) as recorder:
        recorder.open(info, rows[0])
        for row in rows[1 : pushes + 1]:
            recorder.push(row)
        recorder.close("budget", "spent")
    return folder


@pytest.mark.parametrize(
    ("pushes", "moments"),
    [(0, [0, 0, 0, 0]), (3, [0, 1, 2, 3]), (10, [0, 3, 7, 10]), (14, [0, 10, 12, 14])],
)
def test_four_moments_are_shown(tmp_path, run, pushes, moments):
    folder = record(tmp_path, run, pushes)
    assert figures.load(folder).moments == moments
    figures.draw(folder)
    picture = cv2.imread(str(folder.figures / "run.png"))
    assert picture.shape == (round(figures.HEIGHT * figures.DPI), round(figures.WIDTH * figures.DPI), 3)


def test_picture_and_contour_lie_on_each_other(tmp_path, run):
    """The contour is drawn in metres over the picture: they agree to a pixel."""
    from matplotlib.figure import Figure

    folder = record(tmp_path, run, 12)
    loaded = figures.load(folder)
    axes = list(Figure().subplots(1, 4))
    figures.views(axes, loaded)
    shown, image = loaded.moments[1], axes[1].images[0]
    left, right, low, high = image.get_extent()
    rgba = np.asarray(image.get_array())
    rows, columns = np.nonzero(rgba[..., 3] > 128)
    x = left + (columns + 0.5) / rgba.shape[1] * (right - left)
    y = high - (rows + 0.5) / rgba.shape[0] * (high - low)
    middle = [(x.min() + x.max()) / 2, (y.min() + y.max()) / 2]
    contour = loaded.trace.contours[shown]
    np.testing.assert_allclose(middle, (contour.min(0) + contour.max(0)) / 2, atol=0.6 / 480)


def test_a_killed_run_is_drawn_up_to_where_all_files_agree(tmp_path, run):
    folder = record(tmp_path, run, 12)
    lines = folder.table.read_text().splitlines(keepends=True)
    folder.table.write_text("".join(lines[:-2]))
    assert figures.load(folder).last == 10
