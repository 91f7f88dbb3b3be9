"""report.html in a real browser: slider, keys and curve step shape and marker together; tooltips; no network."""

import math
import re

import numpy as np
import pytest

from assessment.report.document import render_html
from assessment.report.figures.index import pictures, write_figures
from assessment.report.language import words_of
from assessment.report.viewer import _jumps, viewer
from assessment.results.joint_states import outlines
from assessment.runtime.pool import Pool
from tests.support.analysed import analysed
from tests.support.browser import PATIENCE, browser
from tests.support.results_example import results_example
from tests.support.typed import typed

__all__ = ["browser"]  # a fixture


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    results = analysed("it")
    words = words_of(typed(results))
    some = pictures(typed(results))[:4]  # the rest would take most of the time
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("assessment.report.figures.index.pictures", lambda _: some)
        patch.setattr("assessment.report.document.pictures", lambda _: some)
        write_figures(Pool(0, typed(results)), folder / "figures")
        page = render_html(
            typed(results), folder / "figures", words, interactive=viewer(typed(results), words)
        )
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def requested():
    """What the page asks of the network."""
    return []


@pytest.fixture(scope="module")
def browsing(browser, html, requested):
    page, said = browser.new_page(viewport={"width": 1000, "height": 1400}), []
    page.set_default_timeout(PATIENCE)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("console", lambda line: said.append(line.text))
    page.on("request", lambda request: requested.append(request.url))
    page.goto(html.absolute().as_uri())
    yield page
    assert said == []


@pytest.fixture
def page(browsing):
    select(browsing, 0)
    browsing.evaluate("document.getElementById('viewer').scrollIntoView()")
    return browsing


def select(page, index):
    page.evaluate(
        f"(() => {{ const c = document.getElementById('viewer-path'); c.value = {index};"
        "c.dispatchEvent(new Event('change')); document.getElementById('viewer-frame').focus() })()"
    )


def titles(page):
    return page.evaluate("[...document.getElementById('viewer-path').options].map((o) => o.text)")


def marker(page):
    return page.evaluate(
        "['cx', 'cy'].map((k) => +document.getElementById('viewer-marker-0').getAttribute(k))"
    )


def ring(page, block):
    text = page.evaluate(
        f"document.querySelector('#viewer-shape [data-block=\"{block}\"]').getAttribute('points')"
    )
    return np.array([[float(x), -float(y)] for x, y in (pair.split(",") for pair in text.split())])


def tip(page, selector):
    """What is told where the mouse is in the middle of an element."""
    box = page.locator(selector).first.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    return page.evaluate("document.getElementById('viewer-tip').innerText")


def test_the_page_is_one_file_and_small(html):
    text = html.read_text(encoding="utf-8")
    assert not re.search(r"https?:|//cdn|src=\"(?!data:)|href=\"(?!#)|@import|url\(", text)
    assert len(text) < 3e6


def test_the_pdfs_page_has_no_script(tmp_path, monkeypatch):
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    results = analysed("it")
    assert "<script" not in render_html(typed(results), tmp_path, words_of(typed(results)))


def test_data_cannot_close_the_script():
    results = analysed("it")
    results["geometry"]["blocks"][0]["layer"] = "</script><b>"
    assert "</script" not in viewer(typed(results), words_of(typed(results)))


def test_the_page_asks_for_nothing_from_the_network(page, requested):
    assert {url.partition(":")[0] for url in requested} <= {"file", "data"}
    assert sum(url.startswith("file") for url in requested) == 1


def test_keys_step_the_shape_and_the_marker_together(page):
    results = analysed()
    frames = results["states"]["right support 60 mm"]["pushdown"]["rigid"]["frames"]
    right = next(i for i, b in enumerate(results["geometry"]["blocks"]) if b["support"] == "right")
    seen = []
    for _ in range(3):
        number = page.evaluate("+document.getElementById('viewer-frame').value")
        expected = outlines(typed(results)).moved(frames["configuration"][number])
        assert ring(page, right) == pytest.approx(expected.points[expected.owner == right], abs=2e-5)
        seen.append(marker(page))
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowRight")
    assert seen[0][0] < seen[1][0] < seen[2][0]
    page.keyboard.press("End")
    last = page.evaluate("+document.getElementById('viewer-frame').value")
    assert last == len(frames["index"]) - 1


def test_the_marker_lies_on_the_curve_at_every_step_of_every_path(page):
    for index in range(len(titles(page))):
        select(page, index)
        count = page.evaluate("+document.getElementById('viewer-frame').max")
        line = page.evaluate("document.querySelector('#viewer-curve .s0').getAttribute('points')")
        points = np.array([[float(v) for v in pair.split(",")] for pair in line.split()])
        for number in {0, count // 2, count}:
            page.evaluate(
                f"(() => {{ const s = document.getElementById('viewer-frame'); s.value = {number};"
                "s.dispatchEvent(new Event('input')) })()"
            )
            x, y = marker(page)
            assert np.hypot(*(points - [x, y]).T).min() < 0.6


def test_a_block_and_a_joint_tell_their_figures(page):
    results = analysed()
    index = next(k for k, title in enumerate(titles(page)) if "+x, giunti rigidi" in title)
    select(page, index)
    told = tip(page, '#viewer-shape [data-joint="5"]')
    force = results["states"]["original"]["pushover"]["+x"]["rigid"]["frames"]["force_kN"][0][5]
    normal, shear = (
        float(found.replace(",", ".").replace("−", "-")) for found in re.findall(r"[NT] = (−?\d+,?\d*)", told)
    )
    assert math.hypot(normal, shear) == pytest.approx(math.hypot(*force), rel=1e-2)
    told = tip(page, "#viewer-shape .support")
    assert "Blocco 0" in told and "BASE_SINISTRA" in told
    page.mouse.move(2, 2)
    assert page.evaluate("document.getElementById('viewer-tip').hidden")


def test_magnified_displacements_and_hidden_thrust(page):
    select(page, 0)
    page.keyboard.press("End")
    true = ring(page, 6)
    page.select_option("#viewer-times", "5")
    drawn = outlines(typed(analysed()))
    start = drawn.points[drawn.owner == 6]
    assert ring(page, 6) - start == pytest.approx(5 * (true - start), abs=1e-4)
    joint = next(k for k, each in enumerate(analysed()["geometry"]["joints"]) if 6 in each["blocks"])
    text = page.evaluate(
        f"document.querySelector('#viewer-shape [data-joint=\"{joint}\"]').getAttribute('points')"
    )
    ends = np.array([[float(x) for x in point.split(",")] for point in text.split()]) * (1.0, -1.0)
    others = [ring(page, block) for block in analysed()["geometry"]["joints"][joint]["blocks"]]
    away = [np.linalg.norm(each - end, axis=1).min() for end in ends for each in others]
    assert sum(away) < 0.05 * np.ptp(start)  # the joint lies where the faces of its blocks are drawn
    assert page.evaluate("document.querySelectorAll('#viewer-shape .thrust').length") == 11
    page.evaluate("document.getElementById('viewer-forces').click()")
    assert page.evaluate("document.querySelectorAll('#viewer-shape .thrust').length") == 0
    page.evaluate("document.getElementById('viewer-forces').click()")
    page.select_option("#viewer-times", "1")


def test_pushovers_offer_the_displacements_of_the_limit_states():
    """d = d*/Γ*, mm, along x: negative towards −x."""
    content = results_example("it")["states"]["original"]
    state = typed(results_example("it")).states["original"]
    capacity = content["capacity"]["-x"]
    expected = [1000.0 * capacity[limit]["d_star_m"] / capacity["gamma_star"] for limit in ("SLV", "SLC")]
    found = {jump["label"]: jump["x"] for jump in _jumps(state, "-x", expected[1])}
    assert [found["d_SLV"], found["d_SLC"]] == pytest.approx([-each for each in expected], rel=1e-5)
    end = {
        "d_star_m": 0.002, "a_star_g": 0.1, "a_g_g": 0.1, "demand_a_g_g": 0.2, "zeta_E": 0.5,
        "verified": False,
    }  # fmt: skip
    content["capacity"]["-x"] |= {"SLD": end | {"d_star_m": None}, "SLD elastic": end}
    with_end = typed({"states": {"original": content}}).states["original"]
    found = {jump["label"]: jump["x"] for jump in _jumps(with_end, "-x", expected[1])}
    assert found["d_SLD"] == pytest.approx(-2.0 / capacity["gamma_star"], rel=1e-5)
    short = {jump["label"] for jump in _jumps(state, "-x", 0.9 * expected[1])}
    assert "d_SLC" not in short, "a path that ends before has no such displacement"
