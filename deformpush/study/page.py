"""One HTML page that needs nothing but itself: no network, no other file."""

import base64
import hashlib
from collections.abc import Sequence
from html import escape
from pathlib import Path

from deformpush.record import palette
from deformpush.study.chart import css
from deformpush.study.tables import Rows, is_number

HERE = Path(__file__).parent


def page(title: str, body: str, data: str = "", code: str = "") -> str:
    """The page; it is light or dark as the browser wishes.

    A browser carries out nothing on it but `code`, and fetches nothing, whatever a run's files say.

    Args:
        title: of the page.
        body: HTML; whoever makes it escapes what comes from files.
        data: JSON that the code finds as `#run`.
        code: a module of JavaScript.
    """
    policy = (
        f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {_permit(code)}; "
        "base-uri 'none'; form-action 'none'"
    )
    light = "".join(f"--{name}:{css(colours[0])};" for name, colours in palette.PAGE.items())
    dark = "".join(f"--{name}:{css(colours[1])};" for name, colours in palette.PAGE.items())
    style = (HERE / "page.css").read_text(encoding="utf-8")
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>:root{{{light}}}@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
        f"{style}</style></head>\n"
        f"<body><main>{body}</main>{_scripts(data, code)}</body></html>\n"
    )


def _permit(code: str) -> str:
    """What of scripts a browser may carry out: this one, known by its digest."""
    if not code:
        return "'none'"
    return f"'sha256-{base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()}'"


def _scripts(data: str, code: str) -> str:
    """Data and code; in the data nothing can end the element it stands in."""
    if not code:
        return ""
    quoted = data.replace("<", "\\u003c")
    return (
        f'<script type="application/json" id="run">{quoted}</script>\n<script type="module">{code}</script>'
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
