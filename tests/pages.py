"""README.md and docs/*.md as tests read them: sections, fenced blocks, tables."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def page(name: str) -> str:
    """The text of a page, named from the top of the checkout."""
    return (ROOT / name).read_text(encoding="utf-8")


def sections(text: str) -> dict[str, str]:
    """What stands below each heading of the second level."""
    return dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL))


def blocks(text: str, *languages: str) -> list[str]:
    """The fenced blocks in these languages."""
    return re.findall(rf"^```(?:{'|'.join(languages)})\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def named_files(text: str, *languages: str) -> dict[str, str]:
    """Those blocks whose first line names a file, or their second behind `# @package`, by that file."""
    named = (
        (re.match(r"(?:# @.*\n)?# (\S+\.\w+)$", block, re.MULTILINE), block)
        for block in blocks(text, *languages)
    )
    return {found[1]: block for found, block in named if found}


def rows(text: str) -> list[dict[str, str]]:
    """The first table of a text: a dictionary for each row, by the titles of its columns."""
    lines = [line for line in text.partition("\n|")[2].partition("\n\n")[0].splitlines() if line]
    titles, _, *body = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [dict(zip(titles, cells, strict=True)) for cells in body]


def write(files: dict[str, str], folder: Path) -> None:
    """Write files, given by name, into a folder."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
