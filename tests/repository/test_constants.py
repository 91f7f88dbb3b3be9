"""Every number by which the program decides stands in docs/theory.md, Constants, with the value that it has."""

import ast
import importlib
import re
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from numbers import Real

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


def numbers_of(value: object) -> tuple[float, ...]:
    """The numbers that a constant is made of, none where it is not made of numbers; of tolerances what has no line."""
    if isinstance(value, Real) and not isinstance(value, bool):
        return (float(value),)
    if is_dataclass(value):
        parts = [getattr(value, f.name) for f in fields(value)]
        if type(value).__name__.endswith("Tolerances"):
            parts = [part for part, f in zip(parts, fields(value), strict=True) if part != f.default]
        value = [part for part in parts if not isinstance(part, bool)]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    found = [numbers_of(part) for part in parts]
    return tuple(number for part in found for number in part) if all(found) else ()


def written(node: ast.expr) -> bool:
    """Whether a value is written as a number here: one that follows from others, or counts, is not."""
    if isinstance(node, ast.Call):
        return ast.unparse(node.func) not in {"range", "slice"}
    return any(isinstance(part, ast.Constant) for part in ast.walk(node))


def constants() -> Iterator[tuple[str, object]]:
    """The constants of the source: of modules by their dotted names, of tolerances as Class.field."""
    for path in (path for place in PLACES for path in sorted((ROOT / "mechanics").glob(place))):
        name = ".".join(path.relative_to(ROOT / "mechanics").with_suffix("").parts).removesuffix(".__init__")
        module = importlib.import_module(f"mechanics.{name}")
        for part in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(part, ast.ClassDef) and part.name.endswith("Tolerances"):
                own = {p.target.id: p.value for p in part.body if isinstance(p, ast.AnnAssign)}
                for field in fields(getattr(module, part.name)):
                    assert field.default is not MISSING, f"{part.name}.{field.name}"
                    if written(own[field.name]):
                        yield f"{part.name}.{field.name}", field.default
            elif isinstance(part, ast.Assign | ast.AnnAssign) and part.value and written(part.value):
                targets = part.targets if isinstance(part, ast.Assign) else [part.target]
                for target in (t for each in targets for t in ast.walk(each) if isinstance(t, ast.Name)):
                    yield f"{name}.{target.id}", getattr(module, target.id)


def test_every_constant_has_a_line_and_every_line_a_constant():
    there = {name: found for name, value in constants() if (found := numbers_of(value))}
    assert there.keys() >= COUNTS and len(there) > 100 + len(COUNTS)
    text = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    rows = ROW.findall(text.split("\n## Constants\n")[1].split("\n## ")[0])
    told = {name: tuple(map(float, value.split(", "))) for name, value in rows}
    assert len(told) == len(rows), "a constant has two lines"
    missing = there.keys() - COUNTS - told.keys()
    assert sorted(missing) == [], "without a line in docs/theory.md, Constants"
    assert sorted(told.keys() - there.keys()) == [], "gone from the source, or derived"
    assert {name: value for name, value in told.items() if value != there[name]} == {}, (
        "another value than the table's"
    )
