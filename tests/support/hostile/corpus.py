"""Thousands of hostile inputs by kind: how each is made, how it is tried, and how many of them a test tries."""

import io
import json
import re
import tempfile
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from assessment.ntc.hazard import RETURN_PERIODS, HazardError, site_curve
from assessment.project.model import build_model, with_repaired_drawing
from assessment.project.plausibility import implausible_hazard
from assessment.project.project import load_project
from assessment.project.xlsx import to_xlsx
from assessment.report.document import inert
from assessment.report.language import slug
from assessment.runtime.errors import ProjectError
from assessment.workflow import run as workflow
from assessment.workflow.checking import read_motions
from mechanics.messages import headed, message, visible
from mechanics.records.record import read_record
from tests.mechanics.records import test_formats as records
from tests.support.block_project import ASSESSMENT, PROJECT, write_block
from tests.support.contract_project import CONTRACT, MINIMAL, write_named_files
from tests.support.hostile import dxf_text
from tests.support.hostile.judge import commanded, judged
from tests.support.hostile.strategies import damaged_bytes, damaged_lines, names, numbers, values
from tests.support.results_example import results_example
from tests.support.typed import typed
from tests.support.wording import in_italian

Try = Callable[[Any], str]
WALL = MINIMAL + '[layers.BASE]\nsupport = "base"\n'
HISTORY = '[[history]]\nrecord = "wave.csv"\ncontacts = "rigid"\nwindow_s = [0.1, 0.9]\ntime_step_s = 0.01\n'
BLOCK = PROJECT + ASSESSMENT + HISTORY
EVERY = (
    BLOCK
    + """[contacts]
sliding = "associative"
collisions = true
[[tie]]
name = "chain"
from_m = [-0.29, -0.1]
to_m = [-0.29, 4.0]
yield_force_kN = 5.0
stiffness_kN_m = 8000.0
pretension_kN = 0.5
states = ["strengthened"]
[[strengthening]]
name = "strengthened"
of = "base turned"
[strengthening.layers.BASE]
friction = 0.8
[[mechanism]]
name = "corner"
about_m = [0.3, 0.0]
blocks = [1]
[sensitivity]
friction = [0.8, 1.2]
unit_weight = [0.9, 1.1]
[identification]
hypotheses = [{ base = ["x", "rotation"] }]
downward_only = true
[[measurement]]
name = "crack"
kind = "crack"
point_m = [0.3, 0.0]
opening_mm = 3.8
sigma_mm = 0.4
[[measurement]]
name = "lean"
kind = "lean"
point_m = [0.0, 2.0]
rotation_mrad = 2.0
sigma_mrad = 0.5
[[measurement]]
name = "top"
kind = "relative"
point_m = [0.0, 4.0]
from_m = "benchmark"
component = "x"
value_mm = 14.0
sigma_mm = 1.0
[campaign]
records = ["wave.csv"]
settlements = ["base turned"]
shares = [0.0, 0.5, 1.0]
signs = [1, -1]
contacts = "rigid"
method = "stripes"
levels_g = [0.1, 0.2]
measure = "Sa(T)"
period_s = 0.4
spectrum_compatible = false
scale_limits = [0.5, 2.0]
"""
)
"""The block with the tables that it has not: of ties, of what strengthens, of studies, of what was measured."""
SHEETS = {
    "title": "Wall",
    "geometry": {"drawing": "geometry.dxf", "unit": "m", "depth_m": 0.1},
    "material": {"unit_weight_kN_m3": 11.5, "friction": 0.6},
    "layers": {"BASE": {"support": "right"}},
    "control": [{"name": "C1", "point_m": [0.0, 3.2]}],
}


@dataclass(frozen=True)
class Kind:
    """Hostile inputs of one kind: `cases` made by hypothesis, `count` of them in a test.

    `prepared(folder)` returns what tries one and gives the verdict.
    """

    cases: st.SearchStrategy[Any]
    prepared: Callable[[Path], Try]
    count: int


def tried(kind: Kind, factor: float = 1.0) -> Counter[str]:
    """Try the cases of a kind, always the same ones; return how many got which verdict. What fails is raised."""
    counts: Counter[str] = Counter()

    with tempfile.TemporaryDirectory() as name:
        attempt = kind.prepared(Path(name))

        @settings(
            max_examples=max(1, round(factor * kind.count)), derandomize=True, database=None, deadline=None,
            phases=[Phase.generate, Phase.shrink], suppress_health_check=list(HealthCheck),
        )  # fmt: skip
        @given(kind.cases)
        def each(case: Any) -> None:
            counts["tried"] += 1
            counts[attempt(case)] += 1

        each()
    return counts


def _write(path: Path, content: str | bytes) -> None:
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass"))


def _file(
    name: str, begun: Callable[[Path], object], verdict: Callable[[Path], str]
) -> Callable[[Path], Try]:
    """What writes a case to a file of a folder that is `begun`, and tries the folder."""

    def prepared(folder: Path) -> Try:
        begun(folder)

        def attempt(content: str | bytes) -> str:
            _write(folder / name, content)
            return verdict(folder)

        return attempt

    return prepared


def _wall(folder: Path) -> None:
    _write(folder / "project.toml", WALL)


def _loaded(folder: Path) -> str:
    return judged(lambda: load_project(folder))


def _modelled(folder: Path) -> str:
    return judged(lambda: build_model(load_project(folder)))


def _repaired(folder: Path) -> str:
    (folder / "geometry-repaired.dxf").unlink(missing_ok=True)
    return judged(lambda: build_model(with_repaired_drawing(load_project(folder))[0]))


def _reported(folder: Path) -> str:
    with mock.patch.object(workflow, "write", lambda *_, **__: []):
        return commanded("report", folder)


def _numbers_of_a_model(folder: Path) -> Try:
    write_block(folder)
    time = np.arange(0.0, 1.0, 0.01)
    np.savetxt(folder / "wave.csv", np.column_stack([time, 0.1 * np.sin(time)]), delimiter=",", fmt="%.6f")

    def model() -> None:
        project = load_project(folder)
        build_model(project)
        read_motions(project)
        implausible_hazard(project, {})

    def attempt(text: str) -> str:
        _write(folder / "project.toml", text)
        return judged(model)

    return attempt


def _record(folder: Path) -> Try:
    def attempt(case: tuple[str | bytes, float | None]) -> str:
        content, step = case
        _write(folder / "motion.txt", content)
        return judged(lambda: read_record(folder / "motion.txt", step))

    return attempt


def _hazard(folder: Path) -> Try:
    def curve() -> None:
        try:
            site_curve(folder / "grid.txt", 42.02, 13.02).at(475.0)
        except HazardError as error:
            raise ProjectError(f"project.toml: assessment.site: {error}") from None

    def attempt(content: str | bytes) -> str:
        _write(folder / "grid.txt", content)
        return judged(curve)

    return attempt


def _name(_: Path) -> Try:
    """Names in what a terminal, a table, an Italian warning and a file name make of them."""

    def attempt(name: str) -> str:
        assert all(c.isprintable() for c in visible(name))
        assert not str(inert(name)).startswith(("=", "+", "-", "@", "\t", "\r"))
        about = message('layer "{name}" holds no block: what the project says of it has no effect', name=name)
        assert name in in_italian(headed(message("{state}", state=name), about))
        assert re.fullmatch(r"\d+[a-z0-9_]*", slug(typed({"states": {name: {}}}), name))
        return "completed"

    return attempt


def _arguments(folder: Path) -> Try:
    write_block(folder / "block")

    def attempt(name: str) -> str:
        return commanded("check", folder / "absent" / name.replace("\x00", "0"))

    return attempt


@st.composite
def _workbooks(draw: st.DrawFn) -> bytes:
    """A workbook with a part damaged, or its archive; or with hostile cells."""
    how = draw(st.sampled_from(("archive", "part", "left out", "cell")))
    if how == "archive":
        return draw(damaged_bytes(_SHEETS))
    with zipfile.ZipFile(io.BytesIO(_SHEETS)) as archive:
        parts = {part: archive.read(part) for part in archive.namelist()}
    chosen = draw(st.sampled_from(sorted(parts)))
    if how == "part":
        parts[chosen] = draw(damaged_bytes(parts[chosen]))
    elif how == "left out":
        del parts[chosen]
    else:
        found = list(re.finditer(rb"(?<=>)[^<>]+(?=</t>|</v>)", parts[chosen])) or [
            re.search(rb"$", parts[chosen])
        ]
        cell = draw(st.sampled_from(found))
        hostile = draw(values).encode("utf-8", "ignore").replace(b"<", b"&lt;")
        parts[chosen] = parts[chosen][: cell.start()] + hostile + parts[chosen][cell.end() :]
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for part, content in parts.items():
            archive.writestr(part, content)
    return file.getvalue()


def _nodes() -> str:
    values = "\t".join(f"{0.5 + k}\t2.4\t0.3" for k in range(len(RETURN_PERIODS)))
    return "\n".join(f"{13.0 + 0.06 * i}\t{42.0 + 0.05 * j}\t{values}" for i in range(3) for j in range(3))


_SHEETS = to_xlsx(SHEETS)
_TABLE = "T_R;a_g [g];F0;T_C*\n" + "\n".join(
    f"{T_R:g};{0.05 * k:.2f};2.4;0.3" for k, T_R in enumerate(RETURN_PERIODS, 1)
)
_RESULTS = json.dumps(results_example())
_TEXTS = st.sampled_from([text for text in records.FORMATS.values() if isinstance(text, str)])
_STEPS = st.sampled_from((None, 0.005, 1e-6, 10.0))
_DRAWINGS = dxf_text.hostile_drawings() | damaged_lines(dxf_text.WHOLE, numbers)

KINDS: dict[str, Kind] = {
    "project file": Kind(
        damaged_lines(CONTRACT, values) | damaged_bytes(CONTRACT.encode()) | values,
        _file("project.toml", write_named_files, _loaded), 1200,
    ),
    "every table of a project": Kind(
        damaged_lines(EVERY, values) | damaged_lines(EVERY, numbers), _numbers_of_a_model, 800,
    ),
    "drawing": Kind(_DRAWINGS | damaged_bytes(dxf_text.WHOLE.encode()), _file("geometry.dxf", _wall, _modelled), 800),
    "drawing, repaired": Kind(_DRAWINGS, _file("geometry.dxf", _wall, _repaired), 100),
    "drawing, with its picture": Kind(_DRAWINGS, _file("geometry.dxf", _wall, partial(commanded, "check")), 50),
    "workbook": Kind(
        _workbooks(), _file("project.xlsx", lambda folder: (folder / "geometry.dxf").touch(), _loaded), 200,
    ),
    "record": Kind(
        st.tuples(_TEXTS.flatmap(lambda text: damaged_lines(text, numbers)), _STEPS)
        | st.tuples(_TEXTS.flatmap(lambda text: damaged_bytes(text.encode())), _STEPS), _record, 1000,
    ),
    "hazard": Kind(
        damaged_lines(_nodes(), numbers) | damaged_lines(_TABLE, numbers) | damaged_bytes(_TABLE.encode()),
        _hazard, 400,
    ),
    "results": Kind(
        damaged_bytes(_RESULTS.encode()) | values,
        _file("output/results.json", lambda folder: (write_block(folder) / "output").mkdir(), _reported), 300,
    ),
    "name": Kind(names, _name, 500), "argument": Kind(names, _arguments, 100),
}  # fmt: skip
