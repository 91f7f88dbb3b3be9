"""The page in a real browser, as a new user would go: a dropped survey, faults, roles, movements, a run, the report."""

import json
import os
import signal
import subprocess
import sys
import tomllib

import numpy as np
import pytest

from assessment.project.catalogue.new_project import write_drawing
from tests.support.browser import PATIENCE, browser
from tests.support.structures import rectangle

__all__ = ["browser"]  # a fixture


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """The folder of the new projects."""
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def served(home):
    """The address of `assesto app` without a project."""
    command = [sys.executable, "-m", "assessment.cli", "app", "--no-browser"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    server = subprocess.Popen(command, cwd=home, env=environment, stdout=subprocess.PIPE, text=True)
    yield server.stdout.readline().strip()
    server.send_signal(signal.SIGINT)
    server.communicate()


@pytest.fixture
def page(browser, served):
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    found = context.new_page()
    found.set_default_timeout(PATIENCE)
    wrong = []
    found.on("pageerror", lambda error: wrong.append(str(error)))
    found.on("console", lambda said: wrong.append(said.text) if "Content Security" in said.text else None)
    found.goto(served)
    found.wait_for_selector("body[data-open]")
    if found.get_attribute("body", "data-open") == "true":
        found.click("#home")
        found.wait_for_selector("body[data-open=false]")  # else a drop goes to the project that is still open
    yield found
    context.close()
    assert wrong == []


def survey(path, lifted=0.0):
    """A beam on two piers on two bases in a frame, as somebody draws it; the beam may lie in its piers by a slip."""
    layout = {
        "BASI": [rectangle(-2.4, -0.3, -1.0, 0.0), rectangle(1.0, -0.3, 2.4, 0.0)],
        "PILE": [rectangle(-2.0, 0.0, -1.4, 3.0), rectangle(1.4, 0.0, 2.0, 3.0)],
        "TRAVE": [rectangle(-2.0, 3.0 + lifted, 2.0, 3.5)],
        "CARTIGLIO": [rectangle(-6.0, -3.0, 6.0, 6.0)],
    }
    write_drawing(path, {layer: [np.array(each) for each in blocks] for layer, blocks in layout.items()})
    return path


def file_of(home, name):
    return tomllib.loads((home / name / "project.toml").read_text(encoding="utf-8"))


def changed(page, job):
    """Do what changes the project file, and wait until the page has the new one."""
    before = page.get_attribute("body", "data-digest")
    job()
    page.wait_for_selector(f"body:not([data-digest='{before}'])")


def fill(page, at, text):
    def typed():
        page.fill(f"[data-at='{at}']", text)
        page.press(f"[data-at='{at}']", "Enter")

    changed(page, typed)


def centre(page, block):
    page.wait_for_selector("body[data-model=shown]")  # else it may be drawn anew meanwhile
    box = page.locator(f"[data-block='{block}']").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page, *points):
    page.mouse.move(*points[0])
    page.mouse.down()
    for point in points[1:]:
        page.mouse.move(*point, steps=6)
    page.mouse.up()


def begin(page, home, name, lifted=0.0):
    """Drop a survey and answer what is asked of it."""
    page.wait_for_selector("[data-drop=drawing]", state="attached")
    page.set_input_files("[data-drop=drawing]", survey(home / "survey.dxf", lifted))
    page.wait_for_selector("#new-title")
    for key, value in {"title": name, "depth": "0,5", "weight": "20"}.items():
        page.fill(f"#new-{key}", value)
    page.click("#new-make")
    page.wait_for_selector("body[data-model=shown]")
    assert "CARTIGLIO" not in page.inner_text("#panel")  # what is ignored is not gone


def test_from_a_dropped_survey_to_the_report(page, home):
    begin(page, home, "portal", lifted=-0.004)

    # faults, and a repair that tells its changes first
    page.wait_for_selector("#repair")
    assert "overlap" in page.inner_text("#problems")
    page.click("#repair")
    page.wait_for_selector("#repair-apply")
    assert file_of(home, "portal")["geometry"]["drawing"] == "survey.dxf"
    changed(page, lambda: page.click("#repair-apply"))
    assert file_of(home, "portal")["geometry"]["drawing"] == "survey-repaired.dxf"
    page.wait_for_selector("body[data-model=shown]")

    # roles that the drawing proposes, by layer and by lasso
    assert [each["support"] for each in file_of(home, "portal")["region"]] == ["sinistro", "destro"]
    page.click("[data-block='4']")
    fill(page, "layers.TRAVE.vertical_load_kN", "2,5")
    x, y = centre(page, 2)
    page.click("[data-tool=lasso]")
    drag(page, (x - 60, y - 30), (x + 60, y - 30), (x + 60, y + 30), (x - 60, y + 30))
    changed(page, lambda: page.click("#make-region"))
    fill(page, "region.2.friction", "0,7")
    page.click("[data-tool=select]")
    page.wait_for_selector("body[data-model=shown]")

    # a control point by click, which takes the corner; undone to the byte, and done again
    before = (home / "portal" / "project.toml").read_bytes()
    page.click("[data-tool=control]")
    box = page.locator("[data-block='4']").bounding_box()
    changed(page, lambda: page.mouse.click(box["x"] + 2, box["y"] + 2))
    assert file_of(home, "portal")["control"] == [{"name": "C1", "point_m": [-2.0, 3.5]}]
    changed(page, lambda: page.click("#undo"))
    assert (home / "portal" / "project.toml").read_bytes() == before
    changed(page, lambda: page.click("#redo"))

    # a record of one column: the page asks for its time step
    (home / "column.csv").write_text("\n".join(f"{0.001 * (k % 7):.4f}" for k in range(500)))
    page.once("dialog", lambda dialog: dialog.accept("0,01"))
    page.click("[data-step=earthquake]")
    changed(page, lambda: page.set_input_files("[data-drop=record]", home / "column.csv"))
    assert file_of(home, "portal")["history"][0]["time_step_s"] == 0.01
    changed(page, lambda: page.click("#undo"))
    page.click("[data-step=settlements]")

    # a support that is dragged: the structure follows, and the way is written
    page.click("[data-tool=select]")
    page.click("[data-step=settlements]")
    page.wait_for_selector("body[data-model=shown]")
    x, y = centre(page, 0)
    drag(page, (x, y), (x - 20, y + 4))
    page.wait_for_selector("#drawing[data-settled=written]")
    proposed, movement = file_of(home, "portal")["settlements"]
    assert [proposed["support"], movement["support"]] == ["destro", "sinistro"]
    assert movement["displacement_m"][0] < 0.0 > movement["displacement_m"][1]
    page.wait_for_selector("body[data-model=shown]")
    assert "Rx" in page.inner_text("#caption")
    assert page.get_attribute("[data-block='4']", "transform")  # the shape stays beside its numbers
    page.press("#drawing", "Escape")

    # a tie by two clicks
    page.click("[data-tool=chain]")
    page.mouse.click(*centre(page, 2))
    changed(page, lambda: page.mouse.click(*centre(page, 3)))
    assert len(file_of(home, "portal")["tie"]) == 1
    changed(page, lambda: page.click("#undo"))

    # a push towards +x alone, as drawn; a run that is stopped, and taken up again
    for _ in range(2):
        changed(page, lambda: page.click("[data-remove='settlements.0']"))
    file = home / "portal" / "project.toml"
    changed(page, lambda: file.write_bytes(b'scatter = 1\naccuracy = "fast"\n' + file.read_bytes()))
    page.click("[data-step=push]")
    changed(page, lambda: page.click("[data-at='pushover.directions.+x']"))
    page.wait_for_selector("body[data-model=shown]")  # the form is drawn again until then
    fill(page, "pushover.increment_m", "0,00001")
    page.wait_for_selector("#run:not([disabled])")
    page.click("#run")
    page.wait_for_selector("body[data-run=running] progress")
    page.click("#stop")
    page.wait_for_selector("#run-state[data-running=false][data-code='3']")
    page.click("[data-step=report]")
    fill(page, "report.client", "Comune di Prova")
    page.click("[data-step=push]")
    fill(page, "pushover.increment_m", "0,02")
    page.wait_for_selector("#run:not([disabled])")
    page.click("#run")
    page.wait_for_selector("#run-state[data-running=false][data-code='0']")
    page.wait_for_selector("#fresh")
    frame = page.frame_locator("#report-frame")
    frame.locator("#viewer-shape polygon.block").first.wait_for()
    assert "α" in page.inner_text("#summary")

    # the title page; another print is begun, and what is stale is told
    page.click("[data-step=report]")
    with page.expect_download() as kept:
        page.click("#panel a:has-text('results.json')")
    assert (
        json.loads(kept.value.path().read_text(encoding="utf-8"))["echo"]["report"]["client"]
        == "Comune di Prova"
    )
    page.click("#print")
    page.wait_for_selector("#print[disabled]")
    page.click("#stop")
    page.wait_for_selector("#print:not([disabled])")
    page.click("[data-step=materials]")
    fill(page, "material.friction", "0,5")
    page.click("[data-step=results]")
    page.wait_for_selector("#stale")


def test_with_the_keyboard_alone(page, home):
    begin(page, home, "keys")
    page.focus("#drawing")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Enter")
    fill(page, "layers.BASI.friction", "0,5")
    page.wait_for_selector("body[data-model=shown]")
    page.focus("#drawing")
    page.keyboard.press("m")
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Shift+ArrowRight")
    models = []
    page.route("**/model", lambda route: models.append((route, route.fetch())))
    changed(page, lambda: page.keyboard.press("Enter"))
    page.wait_for_selector("#drawing[data-settled=written]")
    movement = file_of(home, "keys")["settlements"][1]
    assert (movement["support"], movement["displacement_m"]) == ("sinistro", [0.0001, -0.003])
    page.keyboard.press("Escape")
    page.keyboard.press("m")  # before the structure is known: told
    assert "nothing is wrong" in page.inner_text("#caption")
    patience = iter(range(PATIENCE // 50))
    while not models and next(patience, None) is not None:
        page.wait_for_timeout(50)
    changed(page, lambda: page.keyboard.press("Control+z"))
    assert len(file_of(home, "keys")["settlements"]) == 1

    # a model that comes late, of the file before the undo: what is shown stays
    route, late = models[0]
    route.fulfill(response=late)
    page.wait_for_timeout(300)
    assert page.get_attribute("body", "data-model") == "shown"
    page.unroute("**/model")

    # Escape while the way is computed: nothing is written
    def give_up(route):
        if '"whole":true' in route.request.post_data:
            page.keyboard.press("Escape")
        route.continue_()

    page.route("**/live", give_up)
    for key in ("ArrowLeft", "m", "ArrowDown"):
        page.keyboard.press(key)
    with page.expect_response(lambda answer: '"whole":true' in (answer.request.post_data or "")):
        page.keyboard.press("Enter")
    page.wait_for_timeout(300)
    assert len(file_of(home, "keys")["settlements"]) == 1


DRAWN = "import('/static/app.js').then((app) => app.renderPanel())"  # as when a check comes back, or a run goes on


def test_a_form_that_is_drawn_again_keeps_what_is_typed_marked_and_pressed(page, home):
    begin(page, home, "typist")
    page.click("[data-step=materials]")

    # what is marked is replaced by what is typed
    page.focus("[data-at='material.unit_weight_kN_m3']")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.dataset.at") == "material.friction"
    page.evaluate(DRAWN)
    page.keyboard.type("0,7")
    changed(page, lambda: page.keyboard.press("Enter"))
    assert file_of(home, "typist")["material"]["friction"] == 0.7

    # an entry on its way is shown, also where what is typed next waits for it
    def leave():
        page.focus("[data-at='material.friction']")
        page.keyboard.press("Control+a")
        page.keyboard.type("0,5")
        page.keyboard.press("Tab")
        page.evaluate(DRAWN)
        assert page.input_value("[data-at='material.friction']") == "0,5"

    changed(page, leave)
    assert file_of(home, "typist")["material"]["friction"] == 0.5

    # the first half of a pair, while the second is not there
    page.click("[data-step=site]")
    changed(page, lambda: page.click("[data-add=sensitivity]"))
    page.focus("[data-at='sensitivity.friction.0']")
    page.keyboard.type("0,8")
    page.keyboard.press("Tab")
    page.evaluate(DRAWN)
    page.keyboard.type("1,2")
    changed(page, lambda: page.keyboard.press("Enter"))
    assert file_of(home, "typist")["sensitivity"]["friction"] == [0.8, 1.2]

    # a button under the finger, and one that has the focus
    page.wait_for_selector("#problems .wrong:has-text('sensitivity')")
    page.hover("[data-remove=sensitivity]")
    page.mouse.down()
    page.evaluate(DRAWN)
    changed(page, page.mouse.up)
    assert "sensitivity" not in file_of(home, "typist")
    page.focus("[data-add=sensitivity]")
    page.evaluate(DRAWN)
    assert page.evaluate("document.activeElement.dataset.add") == "sensitivity"
    page.hover("[data-step=push]")
    page.mouse.down()
    file = home / "typist" / "project.toml"
    changed(page, lambda: file.write_bytes(b"scatter = 1\n" + file.read_bytes()))
    page.mouse.up()
    page.wait_for_selector("body[data-step=push]")


def test_what_goes_wrong_is_told_and_nothing_is_lost(page, home):
    begin(page, home, "wrong")
    folder = home / "wrong"
    page.wait_for_selector("body[data-model=shown]")
    before = (folder / "project.toml").read_bytes()

    # no drawing; a value out of its range, at its field
    (home / "plan.dxf").write_text("no drawing", encoding="utf-8")
    page.set_input_files("[data-drop=drawing]", home / "plan.dxf")
    page.wait_for_selector("#problems .wrong:has-text('plan.dxf')")
    with (home / "large.dxf").open("wb") as large:
        large.truncate(50_000_001)
    page.set_input_files("[data-drop=drawing]", home / "large.dxf")
    page.wait_for_selector("#problems .wrong:has-text('large.dxf'):has-text('50 MB')")
    page.click("[data-step=materials]")
    assert page.locator("[data-at='layers.CARTIGLIO']").count() == 1  # to be taken for masonry after all
    page.fill("[data-at='material.friction']", "-1")
    page.press("[data-at='material.friction']", "Enter")
    page.wait_for_selector("[data-field='material.friction'].wrong .error:has-text('not less than')")
    assert (folder / "project.toml").read_bytes() == before

    # an editor beside the page, which breaks the file
    changed(page, lambda: (folder / "project.toml").write_bytes(before.replace(b"wrong", b"other", 1)))
    assert "other" in page.inner_text("#title")
    changed(page, lambda: (folder / "project.toml").write_bytes(b"title = "))
    page.wait_for_selector("#problems .wrong:has-text('line 1')")
    assert page.locator("[data-block]").count() == 5
    (folder / "project.toml").write_bytes(before)
    page.wait_for_selector("body[data-model=shown]")

    # both widths: nothing is wider than the window
    for width in (390, 1280):
        page.set_viewport_size({"width": width, "height": 800})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
