"""`after = "name"` of a settlement: it begins in the state of another one, and what does not come back is told."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.analyses.states import Request, analyse_states
from assessment.project.catalogue.new_project import new_project
from assessment.project.model import build_model, state_models
from assessment.project.project import load_project
from assessment.runtime.errors import ProjectError
from assessment.runtime.tasks import Workers
from mechanics import pushdown
from tests.support.wording import in_italian


def movement(name: str, support: str, x: float, z: float, *more: str) -> str:
    keys = [
        f'name = "{name}"',
        f'support = "{support}"',
        f"displacement_m = [{x}, {z}]",
        "increment_m = 0.002",
        *more,
    ]
    return "[[settlements]]\n" + "\n".join(keys) + "\n"


FORTH = movement("forth", "destro", 0.01, -0.006)
BACK = movement("back", "destro", -0.01, 0.006, 'after = "forth"')
THEN = movement("then", "sinistro", -0.004, 0.0, 'after = "forth"')


def project(folder, *tables: str):
    new_project(folder, "buttressed-arch", {})
    text = (folder / "project.toml").read_text(encoding="utf-8").partition("[[settlements]]")[0]
    (folder / "project.toml").write_text(text + "".join(tables), encoding="utf-8")
    return load_project(folder)


def analysed(made, *names: str, behaviour="rigid"):
    drawn = build_model(made).assembly
    models = state_models(made, drawn)
    requests = [Request(made, models[name], made.settlement_of(name), behaviour) for name in names]
    with Workers(jobs=1) as workers:
        return drawn, dict(zip(names, analyse_states(requests, workers), strict=True))


def test_each_movement_begins_where_the_one_before_it_ends(tmp_path):
    """Whatever the order in the file, and though only the last state is asked for."""
    made = project(tmp_path / "p", THEN, FORTH)
    drawn, found = analysed(made, "then")
    sliding = made.contacts.sliding
    forth = pushdown(drawn, "destro", (0.01, -0.006), increment=0.002, sliding=sliding)
    then = pushdown(drawn, "sinistro", (-0.004, 0.0), increment=0.002, sliding=sliding, state=forth.final)
    assert abs(found["then"].reached.positions - then.final.positions).max() < 1e-9
    assert found["then"].pushdown.movement_m[-1] == pytest.approx(0.004)
    assert not found["then"].warnings


@pytest.mark.parametrize(
    ("behaviour", "said"), [("rigid", "and so are the blocks"), ("elastic", "stay away by up to")]
)
def test_what_does_not_come_back_is_told(tmp_path, behaviour, said):
    """Hinges of rigid joints close again; elastic joints that have slid stay where they are."""
    drawn, found = analysed(project(tmp_path / "p", FORTH, BACK), "forth", "back", behaviour=behaviour)
    reached = found["back"].reached.positions
    assert reached[~drawn.movable] == pytest.approx(drawn.initial.positions[~drawn.movable], abs=1e-12)
    [told] = [text for text in found["back"].warnings if "again where they were as drawn" in text]
    assert said in told and "di nuovo dove erano nel disegno" in in_italian(told)
    away = np.hypot(*(reached - drawn.initial.positions)[:, :2].T).max()
    assert (away > 1e-6) == (behaviour == "elastic") and (behaviour == "rigid" or f"{away:.3g} m" in told)


def test_a_state_that_was_not_reached_is_no_beginning(tmp_path):
    fall = movement("fall", "destro", 0.3, 0.0).replace("0.002", "0.02")
    _, found = analysed(project(tmp_path / "p", fall, BACK.replace("forth", "fall")), "back")
    assert found["back"].reached is None and not found["back"].pushover
    [failure] = found["back"].failures
    assert "the state that the movement begins in was not reached" in failure


@pytest.mark.parametrize(
    ("tables", "key", "said"),
    [
        (
            (FORTH, BACK.replace('after = "forth"', 'after = "fort"')),
            "settlements[2].after",
            'did you mean "forth"?',
        ),
        (
            (FORTH + 'after = "back"\n', BACK),
            "settlements[1].after",
            "the movements begin in each other's states",
        ),
        ((FORTH + 'after = "forth"\n',), "settlements[1].after", "begin in each other's states"),
        (
            (
                FORTH,
                BACK,
                '[[tie]]\nname = "chain"\nfrom_m = [-0.3, 0.5]\nto_m = [0.3, 0.5]\nstates = ["back"]\n',
            ),
            "settlements[2].after",
            'the tie "chain" is there in one of "forth" and "back" alone',
        ),
        ((FORTH, BACK + "steps = 4\n", "[pushover]\n"), "settlements[2].steps", "leave it out"),
        ((FORTH, BACK, '[campaign]\nrecords = ["generate:3"]\n'), "campaign.settlements", '"back" does not'),
    ],
)
def test_what_has_no_beginning_is_refused(tmp_path, tables, key, said):
    with pytest.raises(ProjectError) as refused:
        project(tmp_path / "p", *tables)
    assert any(
        line.startswith(f"project.toml: {key}: ") and said in line for line in str(refused.value).splitlines()
    )
