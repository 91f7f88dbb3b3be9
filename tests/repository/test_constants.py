"""Every number by which the program decides stands in docs/theory.md, Constants, with the value that it has."""

import ast
import importlib
import numbers
import re
from dataclasses import MISSING, fields, is_dataclass

import pytest

from tests import ROOT

PLACES = ("procedures/*.py", "steps/*.py", "solvers/*.py", "kernels/**/*.py", "program.py")
ROW = re.compile(r"^\| [^|]+ \| `([\w.]+)` \| ([^|]+) \| [^|]+ \|$", re.MULTILINE)

# columns of arrays, entries of a record, codes: they count, and decide nothing
COUNTS = {
    "kernels.bed.LINES", "kernels.dynamics.step.FAR", "kernels.dynamics.step.RESTS",
    "kernels.dynamics.step.UNSOLVED", "kernels.dynamics.motion.ENERGIES", "kernels.dynamics.motion.GAPS",
    "kernels.dynamics.motion.JOINT", "kernels.dynamics.motion.LONGER", "kernels.dynamics.motion.MIDDLE",
    "kernels.dynamics.motion.N1", "kernels.dynamics.motion.REMAINS", "kernels.dynamics.motion.SPRING",
    "kernels.dynamics.motion.SUNK", "kernels.dynamics.newton.KNOWN", "kernels.interior.joint_law.KNOWN",
    "kernels.interior.joint_law.LANES", "kernels.joint.CURVED", "kernels.joint.FACE",
    "kernels.joint.LEVERS", "kernels.joint.PLACE", "kernels.joint.SHIFTS", "kernels.joint.SLIDE",
    "kernels.law.DASHPOTS", "kernels.law.LAW", "kernels.linalg.simd_tiles.BYTES",
    "kernels.linalg.simd_tiles.COLUMNS", "kernels.linalg.simd_tiles.ROWS",
}  # fmt: skip


def numbers_of(value: object) -> tuple[float, ...] | None:
    """The numbers that a constant is made of, None where it is not made of numbers; a flag is none."""
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        return (float(value),)
    if is_dataclass(value) and type(value).__name__.endswith("Tolerances"):
        # its fields have lines of their own: what differs from them
        parts = [getattr(value, f.name) for f in fields(value) if getattr(value, f.name) != f.default]
    elif is_dataclass(value):
        parts = [getattr(value, f.name) for f in fields(value)]
        parts = [part for part in parts if not isinstance(part, bool)]
    elif isinstance(value, dict):
        parts = list(value.values())
    elif isinstance(value, tuple):
        parts = list(value)
    else:
        return None
    found = [numbers_of(part) for part in parts]
    if not found or None in found:
        return None
    return tuple(number for part in found for number in part or ())


def written(node: ast.expr) -> bool:
    """Whether a value is written as a number here: one that follows from others, or counts, is not."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("range", "slice"):
        return False
    if isinstance(node, ast.Call):
        return True
    return any(isinstance(part, ast.Constant) for part in ast.walk(node))


def constants() -> dict[str, tuple[float, ...]]:
    """The constants of the source: of modules by their dotted names, of tolerances as Class.field."""
    found: dict[str, tuple[float, ...] | None] = {}
    for place in PLACES:
        for path in sorted((ROOT / "mechanics").glob(place)):
            name = ".".join(path.relative_to(ROOT / "mechanics").with_suffix("").parts)
            name = name.removesuffix(".__init__")
            module = importlib.import_module(f"mechanics.{name}")
            for part in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(part, ast.ClassDef) and part.name.endswith("Tolerances"):
                    values = {p.target.id: p.value for p in part.body if isinstance(p, ast.AnnAssign)}
                    for field in fields(getattr(module, part.name)):
                        assert field.default is not MISSING, f"{part.name}.{field.name}"
                        if written(values[field.name]):
                            found[f"{part.name}.{field.name}"] = numbers_of(field.default)
                elif isinstance(part, ast.Assign | ast.AnnAssign) and part.value and written(part.value):
                    targets = part.targets if isinstance(part, ast.Assign) else [part.target]
                    for target in (t for each in targets for t in ast.walk(each) if isinstance(t, ast.Name)):
                        found[f"{name}.{target.id}"] = numbers_of(getattr(module, target.id))
    return {name: value for name, value in found.items() if value is not None and name not in COUNTS}


def table() -> dict[str, tuple[float, ...]]:
    """The lines of the table: name and value."""
    text = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    rows = ROW.findall(text.split("\n## Constants\n")[1].split("\n## ")[0])
    assert len({name for name, _ in rows}) == len(rows), "a constant has two lines"
    return {name: tuple(float(number) for number in value.split(", ")) for name, value in rows}


def test_every_constant_has_a_line_and_every_line_a_constant():
    there, told = constants(), table()
    assert len(there) > 100
    assert sorted(there.keys() - told.keys()) == [], "without a line in docs/theory.md, Constants"
    assert sorted(told.keys() - there.keys()) == [], "gone from the source, or derived"
    wrong = {name: (told[name], value) for name, value in there.items() if told[name] != value}
    assert not wrong, "another value than that of the table"


def test_counts_are_there():
    for name in COUNTS:
        module, _, last = name.rpartition(".")
        assert isinstance(getattr(importlib.import_module(f"mechanics.{module}"), last), int), name


@pytest.mark.parametrize(
    ("text", "counts"),
    [("1e-3", True), ("(0.1, 2)", True), ("1e3 * GOOD", True), ("GOOD", False), ("range(4)", False)],
)
def test_a_derived_value_needs_no_line(text, counts):
    assert written(ast.parse(text, mode="eval").body) is counts
