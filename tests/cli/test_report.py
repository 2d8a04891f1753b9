"""The verb `report`: whole in itself, and right in a browser."""

import re
import shutil
import subprocess

import cv2
import pytest

from deformpush.cli import report
from deformpush.errors import UserError
from deformpush.study.chart import Chart, ticks
from deformpush.study.page import table

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium (Debian: chromium)")
WIDTH = "<script>document.title = document.documentElement.scrollWidth + ' in ' + innerWidth</script></body>"


@pytest.fixture(scope="module")
def pages(sweep, tmp_path_factory):
    """The pages of a run of 12 pushes and of its sweep."""
    folder = tmp_path_factory.mktemp("pages")
    report.main([str(sweep / "acq.w=1,seed=0"), "--out", str(folder / "run.html")])
    report.main([str(sweep), "--out", str(folder / "sweep.html")])
    return folder


def browse(*flags: str) -> str:
    """What headless Chromium prints."""
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", *flags]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=200).stdout


@pytest.mark.parametrize("name", ["run.html", "sweep.html"])
def test_a_page_needs_nothing_but_itself(pages, name):
    text = (pages / name).read_text()
    assert re.findall(r"https?:|//[a-z]+\.|<link|@import|url\(|src=(?!\"data:)|href=(?!\"data:)", text) == []
    assert "NaN" not in text
    assert ">nan" not in text


def test_the_page_of_a_run_tells_of_every_push(pages):
    text = (pages / "run.html").read_text()
    assert [f"id=row{k}>" in text for k in range(14)] == [True] * 13 + [False]
    assert "Settings that differ from the defaults" in text
    assert "acq: {_target_: Y, w: 1.0}" in text


def test_the_page_of_a_sweep_shows_where_each_run_ended(pages):
    text = (pages / "sweep.html").read_text()
    assert text.count("<image ") == 4
    assert "acq.w 1, seed 1: budget, 15 pushes" in text


@pytest.mark.screen
@browser
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("name", ["run.html", "sweep.html"])
def test_nothing_sticks_out_sideways(pages, tmp_path, name, width):
    """Wide tables scroll in themselves; a frame gives the page its width, which no window makes so narrow."""
    inner = (
        (pages / name)
        .read_text()
        .replace("</body>", WIDTH.replace("document.title", "parent.document.title"))
    )
    (tmp_path / "inner.html").write_text(inner)
    frame = f'<body><iframe src="inner.html" style="width:{width}px;height:900px;border:0"></iframe></body>'
    (tmp_path / "outer.html").write_text(frame)
    dom = browse(
        "--allow-file-access-from-files", "--window-size=1400,950",
        "--virtual-time-budget=4000", "--dump-dom",
        f"file://{tmp_path / 'outer.html'}",
    )  # fmt: skip
    assert re.search(r"<title>(.*?)</title>", dom)[1] == f"{width} in {width}"


@pytest.mark.screen
@browser
def test_the_slider_moves_picture_words_and_cursors(pages):
    dom = browse("--virtual-time-budget=4000", "--dump-dom", f"file://{pages / 'run.html'}#k=6")
    assert "After push 6 of 12" in dom
    assert 'class="cursor" style="display: block; left: 50%;"' in dom
    assert 'id="row6" class="now"' in dom


@pytest.mark.screen
@browser
def test_it_is_dark_where_the_browser_is(pages, tmp_path):
    ground = {}
    for scheme, number in (("light", 1), ("dark", 0)):
        picture = tmp_path / f"{scheme}.png"
        browse(
            f"--blink-settings=preferredColorScheme={number}", "--window-size=1280,900",
            f"--screenshot={picture}", f"file://{pages / 'sweep.html'}",
        )  # fmt: skip
        ground[scheme] = cv2.imread(str(picture))[5, 5].mean()
    assert ground["light"] > 240
    assert ground["dark"] < 40


def test_a_run_without_its_pictures_is_refused_in_one_line(sweep, tmp_path):
    run = shutil.copytree(sweep / "acq.w=2,seed=0", tmp_path / "run")
    (run / "views.npz").write_bytes(b"")
    with pytest.raises(UserError, match="damaged, or not written by a run"):
        report.main([str(run)])
    with pytest.raises(UserError, match="no such folder"):
        report.main([str(tmp_path / "nowhere")])


def test_a_page_is_not_overwritten_unasked(sweep, tmp_path):
    run = shutil.copytree(sweep / "acq.w=2,seed=0", tmp_path / "run")
    assert report.main([str(run)]) == 0
    with pytest.raises(UserError, match=r"report\.html exists already"):
        report.main([str(run)])
    assert report.main([str(run), "--overwrite"]) == 0


def test_text_is_shown_as_it_is():
    assert "<td>&lt;b&gt;</td>" in table([["a"], ["<b>"]])


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0, 250, [0, 100, 200]),
        (0, 1, [0, 0.5, 1]),
        (-0.7, 0.5, [-0.5, 0, 0.5]),
        (0, 0.16, [0, 0.05, 0.1, 0.15]),
    ],
)
def test_ticks_are_round(low, high, expected):
    assert ticks(low, high, 4) == pytest.approx(expected)


def test_a_chart_without_numbers_is_still_a_chart():
    assert "<figure" in Chart("nothing", 0).html()
