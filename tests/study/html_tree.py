"""An HTML page as a tree, so that tests can look for what it shows."""

from collections.abc import Iterator
from html.parser import HTMLParser

EMPTY = {"br", "meta", "input", "img"}


class Node:
    """An element: its attributes and what is inside."""

    def __init__(self, tag: str, attributes: dict[str, str | None]) -> None:
        self.tag, self.attributes = tag, attributes
        self.inside: list[Node | str] = []

    def all(self, tag: str = "", **attributes: str) -> "list[Node]":
        """Elements below this one, in order, with this tag and these attributes (`class_` for `class`)."""
        wanted = {name.rstrip("_"): value for name, value in attributes.items()}
        return [
            node
            for node in self._below()
            if tag in ("", node.tag) and all(node.attributes.get(k) == v for k, v in wanted.items())
        ]

    def one(self, tag: str = "", **attributes: str) -> "Node":
        """The only such element."""
        (found,) = self.all(tag, **attributes)
        return found

    def after(self, heading: str) -> "Node":
        """The element that follows an `h2` with this text."""
        found = [node for node in self._below() if node.tag != "h2" or node.text == heading]
        i = next(i for i, node in enumerate(found) if (node.tag, node.text) == ("h2", heading))
        return found[i + 1]

    @property
    def text(self) -> str:
        """All text inside."""
        return "".join(part if isinstance(part, str) else part.text for part in self.inside)

    @property
    def rows(self) -> list[list[str]]:
        """The cells of the table below, header first."""
        return [[cell.text for cell in row.all() if cell.tag in ("th", "td")] for row in self.all("tr")]

    def _below(self) -> Iterator["Node"]:
        for part in self.inside:
            if isinstance(part, Node):
                yield part
                yield from part._below()


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open = [Node("", {})]

    def handle_starttag(self, tag, attrs):
        node = Node(tag, dict(attrs))
        self.open[-1].inside.append(node)
        if tag not in EMPTY:
            self.open.append(node)

    def handle_startendtag(self, tag, attrs):
        self.open[-1].inside.append(Node(tag, dict(attrs)))

    def handle_endtag(self, tag):
        if tag not in EMPTY:
            assert self.open.pop().tag == tag, f"</{tag}> closes nothing"

    def handle_data(self, data):
        self.open[-1].inside.append(data)


def read(html: str) -> Node:
    """The tree of a page; every element in it must be closed."""
    reader = _Reader()
    reader.feed(html)
    reader.close()
    (root,) = reader.open
    return root
