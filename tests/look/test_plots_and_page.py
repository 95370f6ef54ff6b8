"""Diagrams and the report page: complete, self-contained, and safe with any name."""

from __future__ import annotations

from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from mien.core import Clip, InputError, Note
from mien.look import page, plots

NASTY = '<script>alert("x")</script>&'


@pytest.fixture
def clip(rng: np.random.Generator) -> Clip:
    names = ("browInnerUp", "eyeBlinkLeft", "jawOpen", NASTY, "still")
    values = np.cumsum(rng.normal(0, 0.1, (80, 5)), axis=0) * [1, 1, 1, 1, 0]
    values[10:14] = np.nan
    return Clip(names, values, 30.0)


def words(svg: str) -> set[str]:
    return {text.strip() for text in ElementTree.fromstring(svg).itertext()}


def test_weight_curves_label_the_most_active_channels(clip: Clip) -> None:
    written = words(plots.as_svg(plots.weight_curves(clip, 4)))
    assert {"browInnerUp", "eyeBlinkLeft", "jawOpen", NASTY} <= written
    assert "still" not in written


@pytest.mark.parametrize(
    ("name", "region"),
    [("browDownLeft", "brows"), ("eyesClosed_L", "eyes"), ("jawDrop", "jaw and mouth"), ("x", "other")],
)
def test_names_tell_regions(name: str, region: str) -> None:
    assert plots.region_of(name) == region


def test_every_diagram_is_svg_and_png(clip: Clip, rng: np.random.Generator) -> None:
    deltas = rng.normal(0, 0.01, (3, 9, 3))
    fit = np.where(rng.random(50) < 0.2, np.nan, 1.0)
    figures = [
        plots.weight_curves(clip, title="weights"),
        plots.similarity_matrix(rng.random((4, 50)), ["a", "b", "c", NASTY], [3, 40], 30.0),
        plots.cumulative_correlation(rng.random(50), [4, 9], 30.0, threshold=0.5),
        plots.fit_error(fit, 30.0),
        plots.fit_error(np.full(5, np.nan), 30.0),
        plots.bars({"a": 0.9, NASTY: float("nan")}, "gain", 1.0),
        plots.sparse_blendshapes(rng.random((9, 3)), ["a", "b", "c"], deltas, 2 * deltas, 0 * deltas, columns=2),
    ]
    for figure in figures:
        svg = plots.as_svg(figure)
        assert ElementTree.fromstring(svg).tag.endswith("svg")
        assert "currentColor" in svg
        assert plots.as_png(figure, dpi=50).startswith(page.PNG)


def test_the_same_diagram_is_the_same_text(clip: Clip) -> None:
    assert plots.as_svg(plots.weight_curves(clip)) == plots.as_svg(plots.weight_curves(clip))


def test_diagrams_of_nothing_and_of_frames_that_do_not_exist_are_refused() -> None:
    with pytest.raises(InputError, match="no curves"):
        plots.weight_curves(Clip((), np.zeros((0, 0)), 30.0))
    with pytest.raises(InputError, match="no bars"):
        plots.bars({}, "gain")
    with pytest.raises(InputError, match="key frame 9 does not exist"):
        plots.cumulative_correlation(np.zeros(9), [9])


class Reader(HTMLParser):
    """Notes the tags, the text, and anything that would be fetched."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.text: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.links += [v or "" for k, v in attrs if k in {"src", "href"} and not (v or "").startswith(("data:", "#"))]

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def test_a_page_escapes_all_names_and_needs_no_other_file(clip: Clip) -> None:
    svg = plots.as_svg(plots.weight_curves(clip))
    sections = [
        page.Prose(f"{NASTY}\n\nSecond paragraph.", NASTY),
        page.Table((NASTY, "gain"), [(NASTY, 1.23456), ("b", None)], NASTY),
        page.Figure(svg, NASTY, NASTY),
        page.Figure(page.PNG + b"rest", NASTY, alt='"quoted"'),
        page.Notes([Note("gaps-filled", NASTY, NASTY), Note("bare", "no place")]),
        page.Notes([]),
    ]
    reader = Reader()
    reader.feed(page.page(NASTY, sections))
    assert "script" not in reader.tags
    assert reader.links == []
    assert "".join(reader.text).count(NASTY) >= 9
    assert {"svg", "img", "table", "figcaption", "style"} <= set(reader.tags)
    assert "1.235" in reader.text
    assert "–" in reader.text


def test_a_table_with_a_short_row_is_refused() -> None:
    with pytest.raises(InputError, match="row 1"):
        page.Table(("a", "b"), [(1, 2), (1,)])


@pytest.mark.parametrize("picture", [b"GIF89a", "<img src=x>"])
def test_a_figure_that_is_neither_png_nor_svg_is_refused(picture: bytes | str) -> None:
    with pytest.raises(InputError, match="PNG"):
        page.Figure(picture)
