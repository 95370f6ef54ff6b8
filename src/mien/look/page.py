"""One report page in one file: no style sheet, script, font or picture from elsewhere.

Everything written by others (names of shapes, files, markers) is escaped.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from dataclasses import dataclass

from mien.core import InputError, Note

PNG = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True)
class Prose:
    """A heading and paragraphs under it, separated by empty lines."""

    text: str
    heading: str = ""


@dataclass(frozen=True)
class Figure:
    """A picture with a caption.

    Attributes:
        picture: the content of a PNG file, or an `<svg>` element made by `plots.as_svg`.
        caption: what it shows and what to look for.
        heading: words above.
        alt: what a person who cannot see it should know; the caption if empty.
    """

    picture: bytes | str
    caption: str = ""
    heading: str = ""
    alt: str = ""

    def __post_init__(self) -> None:
        known = self.picture.startswith(PNG) if isinstance(self.picture, bytes) else self.picture.startswith("<svg")
        if not known:
            raise InputError("a figure must be the bytes of a PNG file or an <svg> element.")


@dataclass(frozen=True)
class Table:
    """Rows of values under column names; numbers stand right.

    Attributes:
        columns: the names.
        rows: as many values each.
        caption: what it shows.
        heading: words above.
    """

    columns: tuple[str, ...]
    rows: Sequence[Sequence[str | int | float | None]]
    caption: str = ""
    heading: str = ""

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.columns):
                raise InputError(f"row {number} of the table has {len(row)} values for {len(self.columns)} columns.")


@dataclass(frozen=True)
class Notes:
    """What was repaired or left out, each with where it happened."""

    notes: Sequence[Note]
    heading: str = "Notes"


Section = Prose | Figure | Table | Notes


def page(title: str, sections: Sequence[Section]) -> str:
    """Return a whole HTML page that needs nothing but itself."""
    body = "\n".join(_section(section) for section in sections)
    name = html.escape(title)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{name}</title>\n<style>{STYLE}</style>\n</head>\n"
        f"<body>\n<main>\n<h1>{name}</h1>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _section(section: Section) -> str:
    heading = f"<h2>{html.escape(section.heading)}</h2>\n" if section.heading else ""
    if isinstance(section, Prose):
        inside = _prose(section)
    elif isinstance(section, Figure):
        inside = _figure(section)
    elif isinstance(section, Table):
        inside = _table(section)
    else:
        inside = _notes(section)
    return f"<section>\n{heading}{inside}\n</section>"


def _prose(prose: Prose) -> str:
    return "\n".join(f"<p>{html.escape(text.strip())}</p>" for text in prose.text.split("\n\n") if text.strip())


def _figure(figure: Figure) -> str:
    alt = html.escape(figure.alt or figure.caption, quote=True)
    if isinstance(figure.picture, bytes):
        content = base64.b64encode(figure.picture).decode("ascii")
        picture = f'<img alt="{alt}" src="data:image/png;base64,{content}">'
    else:
        picture = f'<div class="drawing" role="img" aria-label="{alt}">{figure.picture}</div>'
    caption = f"\n<figcaption>{html.escape(figure.caption)}</figcaption>" if figure.caption else ""
    return f"<figure>\n{picture}{caption}\n</figure>"


def _table(table: Table) -> str:
    numeric = [
        bool(table.rows) and all(row[i] is None or isinstance(row[i], (int, float)) for row in table.rows)
        for i in range(len(table.columns))
    ]
    kinds = [' class="number"' if n else "" for n in numeric]
    head = "".join(
        f'<th scope="col"{kind}>{html.escape(name)}</th>' for name, kind in zip(table.columns, kinds, strict=True)
    )
    rows = "\n".join(
        "<tr>"
        + "".join(f"<td{kind}>{html.escape(_written(value))}</td>" for value, kind in zip(row, kinds, strict=True))
        + "</tr>"
        for row in table.rows
    )
    caption = f"<caption>{html.escape(table.caption)}</caption>\n" if table.caption else ""
    return (
        f'<div class="wide"><table>\n{caption}<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table></div>'
    )


def _written(value: str | int | float | None) -> str:
    if value is None or value != value:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _notes(notes: Notes) -> str:
    if not notes.notes:
        return '<p class="faint">Nothing was repaired or left out.</p>'
    items = "\n".join(_note(note) for note in notes.notes)
    return f'<ul class="notes">\n{items}\n</ul>'


def _note(note: Note) -> str:
    place = f" · {html.escape(note.where)}" if note.where else ""
    return (
        f'<li><p>{html.escape(note.message)}</p><p class="faint"><code>{html.escape(note.code)}</code>{place}</p></li>'
    )


STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1f2328; --faint: #656d76; --line: #d8dee4; --tint: #f6f8fa; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #14171a; --ink: #e3e7eb; --faint: #98a2ad; --line: #30363d; --tint: #1c2126; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 56rem; margin: 0 auto; padding: 2rem 1.1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 1.2rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .6rem; overflow-wrap: anywhere; }
p { margin: .5rem 0; max-width: 42rem; overflow-wrap: anywhere; }
figure { margin: 1rem 0; }
figure img, .drawing svg { display: block; max-width: 100%; height: auto; border-radius: 6px; }
.drawing { overflow-x: auto; }
.drawing text { font-family: inherit; }
figcaption, caption, .faint { color: var(--faint); font-size: .9rem; }
figcaption { margin-top: .4rem; max-width: 42rem; }
caption { text-align: left; padding-bottom: .4rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { padding: .32rem .9rem .32rem 0; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { color: var(--faint); font-weight: 600; }
.number { text-align: right; }
.notes { list-style: none; margin: 0; padding: 0; }
.notes li { background: var(--tint); border-left: 3px solid var(--line); border-radius: 4px;
  padding: .4rem .8rem; margin: .5rem 0; }
.notes p { margin: .1rem 0; }
code { font: .86em ui-monospace, SFMono-Regular, Menlo, Consolas, monospace; }
"""
