"""The verb `report`: whole in itself, and right in a browser."""

import json
import re
import shutil
import subprocess

import cv2
import pytest

from deformpush.cli import report
from deformpush.errors import UserError
from tests.study import html_tree

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


def test_a_run_gets_its_page_and_a_sweep_its_own(pages):
    """What stands on them is tested in tests/study, module by module."""
    run, sweep = (html_tree.read((pages / name).read_text()) for name in ("run.html", "sweep.html"))
    assert [node.text for node in run.all("h2")] == ["Settings that differ from the defaults", "Pushes"]
    assert len(run.after("Pushes").rows) == 1 + 13
    settings = {row[0]: row for row in run.after("Settings that differ from the defaults").rows}
    assert settings["acq.w"][1:] == ["2", "1"], "the defaults are those of the command line"
    assert "acq: {_target_: Y, w: 1.0}" in run.one("pre").text
    assert [node.text for node in sweep.all("h2")] == [
        "Variants",
        "Errors by push",
        "Where they ended",
        "Settings that differ",
        "Runs",
    ]
    assert sweep.one("h1").text == "sweep"


@pytest.mark.screen
@browser
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("name", ["run.html", "sweep.html"])
def test_nothing_sticks_out_sideways(pages, tmp_path, name, width):
    """Wide tables scroll in themselves; a frame gives the page its width, which no window makes so narrow."""
    inner = (
        (pages / name)
        .read_text()
        .replace("Content-Security-Policy", "none")  # lets the test's own script run
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
def test_the_slider_moves_view_text_and_cursors(pages):
    dom = browse("--virtual-time-budget=4000", "--dump-dom", f"file://{pages / 'run.html'}#k=6")
    assert "After push 6 of 12" in dom
    data = json.loads(html_tree.read((pages / "run.html").read_text()).one("script", id="run").text)
    assert f'href="data:image/jpeg;base64,{data["pictures"][6]}"' in dom
    assert f'points="{data["contours"][6]}"' in dom
    assert f'points="{" ".join(data["centroids"][:7])}"' in dom
    x, y, to_x, to_y = data["paths"][7]
    assert re.search(rf'<path id="arrow"[^>]* d="M{x:g} {y:g}L{to_x:g} {to_y:g}M', dom)
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
