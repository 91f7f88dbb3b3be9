"""Light SVG files show what matplotlib drew: the same words, lines and areas in the same order, in fewer elements."""

import io
import re
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest

from assessment.report.figures.index import pictures
from assessment.report.figures.style import STYLE
from assessment.report.figures.svg import SVG, lightened
from tests.support.results_example import results_example
from tests.support.typed import typed

STROKED = {"stroke-linejoin": "round", "stroke-linecap": "butt"}


@pytest.fixture(scope="module", params=["model", "pushover_plus_x", "spectra_plus_x_SLV", "mechanism_plus_x"])
def figure(request):
    picture = next(each for each in pictures(typed(results_example())) if each.name == request.param)
    buffer = io.BytesIO()
    with mpl.rc_context(STYLE):
        picture.draw().savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def drawn(svg):
    """Yield every text, mark and subpath: what it is, its looks, its window, its numbers."""

    def walk(element, window):
        window = element.get("clip-path", window)
        tag = element.tag.removeprefix(f"{{{SVG}}}")
        if tag in {"defs", "metadata"}:
            return
        style = dict(part.split(":") for part in element.get("style", "").split(";") if part)
        looks = {key.strip(): value.strip() for key, value in style.items()}
        looks |= {k: v for k, v in element.attrib.items() if re.match("fill|stroke|font|text-anchor", k)}
        if tag == "path":
            for part in element.get("d").split("M")[1:]:
                yield (
                    "path",
                    STROKED | looks,
                    window,
                    re.sub("[LCQz]", " ", part),
                )
        elif tag == "use":
            yield "use", STROKED | looks, window, f"{element.get('x')} {element.get('y')}"
        elif tag in {"text", "tspan"}:
            words = (element.text or "").strip()
            yield tag, words, STROKED | looks, window, element.get("x", "0")
        for child in element:
            yield from walk(child, window)

    return list(walk(ElementTree.fromstring(svg), None))


def floats(numbers):
    return np.array(numbers.split(), dtype=float)


@pytest.mark.parametrize("kind", ["path", "use", "text", "tspan"])
def test_a_light_figure_shows_the_same_in_the_same_order(figure, kind):
    before, after = ([item for item in drawn(svg) if item[0] == kind] for svg in (figure, lightened(figure)))
    assert len(before) == len(after)
    for (*one, numbers), (*other, rounded) in zip(before, after, strict=True):
        assert one == other
        assert floats(rounded) == pytest.approx(floats(numbers), abs=0.006)


def test_a_light_figure_has_fewer_elements(figure):
    before, after = (len(list(ElementTree.fromstring(svg).iter())) for svg in (figure, lightened(figure)))
    assert after < 0.7 * before
    assert len(lightened(figure)) < len(figure)


def test_lightening_twice_changes_nothing(figure):
    assert lightened(lightened(figure)) == lightened(figure)
