"""One HTML page that needs nothing but itself: no network, no other file."""

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path

from deformpush.record import palette
from deformpush.study.chart import css
from deformpush.study.tables import Rows, is_number

HERE = Path(__file__).parent


def page(title: str, body: str, script: str = "") -> str:
    """The page; it is light or dark as the browser wishes."""
    light = "".join(f"--{name}:{css(colours[0])};" for name, colours in palette.PAGE.items())
    dark = "".join(f"--{name}:{css(colours[1])};" for name, colours in palette.PAGE.items())
    style = (HERE / "page.css").read_text(encoding="utf-8")
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>:root{{{light}}}@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
        f"{style}</style></head>\n"
        f"<body><main>{body}</main>{script}</body></html>\n"
    )


def table(rows: Rows, ids: Sequence[str] = ()) -> str:
    """Header and rows as a table that scrolls sideways; columns of numbers stand to the right."""
    header, *body = rows
    right = [bool(body) and all(is_number(row[i]) for row in body) for i in range(len(header))]

    def row(cells: Sequence[str], tag: str, name: str = "") -> str:
        text = "".join(
            f"<{tag}{' class=n' if r else ''}>{escape(cell)}</{tag}>"
            for cell, r in zip(cells, right, strict=True)
        )
        return f"<tr{f' id={name}' if name else ''}>{text}</tr>"

    lines = [row(cells, "td", ids[i] if ids else "") for i, cells in enumerate(body)]
    return f'<div class="wide"><table>{row(header, "th")}{"".join(lines)}</table></div>'


def facts(pairs: Sequence[tuple[str, str]]) -> str:
    """Short facts in boxes: what it is, its value."""
    boxes = "".join(f"<div><span>{escape(name)}</span><b>{escape(value)}</b></div>" for name, value in pairs)
    return f'<div class="facts">{boxes}</div>'


def details(title: str, body: str) -> str:
    """A part that opens when it is asked for."""
    return f"<details><summary>{escape(title)}</summary>{body}</details>"


def picture(data: bytes, kind: str) -> str:
    """A picture as an address that holds it."""
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
