"""The parts that pages are put together of."""

import base64
import hashlib
import json

from deformpush.record import palette
from deformpush.study.chart import css
from deformpush.study.page import details, facts, page, picture, table
from tests.study import html_tree


def test_a_table_shows_every_cell_as_it_is():
    tree = html_tree.read(table([["run", "pushes"], ["<b>", "3"], ["a&b", "-"]], ["one", "two"]))
    assert tree.rows == [["run", "pushes"], ["<b>", "3"], ["a&b", "-"]]
    assert [row.attributes.get("id") for row in tree.all("tr")] == [None, "one", "two"]
    right = [cell.text for cell in tree.all() if cell.attributes.get("class") == "n"]
    assert right == ["pushes", "3", "-"], "numbers stand to the right"


def test_facts_and_details_show_what_they_are_given():
    tree = html_tree.read(facts([("runs", "4"), ("<i>", "<u>")]) + details("<s>", "<p>open</p>"))
    assert [(box.one("span").text, box.one("b").text) for box in tree.one(class_="facts").all("div")] == [
        ("runs", "4"),
        ("<i>", "<u>"),
    ]
    assert (tree.one("summary").text, tree.one("p").text) == ("<s>", "open")


def test_a_page_is_dark_or_light_as_the_browser_wishes():
    tree = html_tree.read(page("<t>", "<p>body</p>"))
    assert (tree.one("title").text, tree.one("main").text) == ("<t>", "body")
    light, _, dark = tree.one("style").text.partition("@media (prefers-color-scheme:dark)")
    for name, colours in palette.PAGE.items():
        assert f"--{name}:{css(colours[0])};" in light
        assert f"--{name}:{css(colours[1])};" in dark


def test_a_picture_is_its_own_address():
    assert picture(b"abc", "png") == "data:image/png;base64,YWJj"


def test_a_page_carries_out_its_own_code_and_nothing_else():
    code = "document.title = 1;"
    text = page("t", "<p>body</p>", '{"name": "</script><script>alert(1)</script>"}', code)
    tree = html_tree.read(text)
    (policy,) = [
        meta.attributes["content"]
        for meta in tree.all("meta")
        if meta.attributes.get("http-equiv") == "Content-Security-Policy"
    ]
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{digest}'" in policy
    assert text.count("<script") == 2
    data, module = tree.all("script")
    assert json.loads(data.text) == {"name": "</script><script>alert(1)</script>"}
    assert module.text == code


def test_a_page_without_code_carries_out_nothing():
    assert "script-src 'none'" in page("t", "<p>body</p>")
