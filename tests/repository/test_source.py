"""The sources: few arguments, what is raised is said, public names, one class an idea; no test looks at the clock."""

import ast
import importlib
import pkgutil
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import mechanics
from mechanics import MechanicsError
from mechanics.messages import SaidError
from tests import ROOT

MOST_ARGUMENTS = 8
KERNELS = ROOT / "mechanics" / "kernels"  # compiled loops; mechanics/kernels/__init__.py has the reason
# templates: functions of the dimensions of a structure
CATALOGUE = ROOT / "assessment" / "project" / "catalogue"
REASON = "arguments: "


@cache
def trees() -> dict[Path, ast.Module]:
    """Every file of the packages, parsed once, and not where tests are collected."""
    paths = (path for folder in ("assessment", "mechanics") for path in sorted((ROOT / folder).rglob("*.py")))
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in paths}


def _within(
    path: Path, lines: list[str], node: ast.AST, about: str
) -> Iterator[tuple[Path, str, ast.FunctionDef, str]]:
    for inner in ast.iter_child_nodes(node):
        if isinstance(inner, ast.FunctionDef):
            yield path, "\n".join(lines[inner.lineno - 1 : inner.end_lineno]), inner, about
        elif isinstance(inner, ast.ClassDef):
            yield from _within(path, lines, inner, ast.get_docstring(inner) or "")


@cache
def every() -> list[tuple[Path, str, ast.FunctionDef, str]]:
    """Every function and method with its file, its source and the docstring of its class, if it has one."""
    return [
        found
        for path, tree in trees().items()
        for found in _within(path, path.read_text(encoding="utf-8").split("\n"), tree, "")
    ]


def _arguments(function: ast.FunctionDef) -> int:
    given = function.args
    named = [each.arg for each in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len([name for name in named if name not in {"self", "cls"}])


def test_a_function_of_many_arguments_says_why():
    found = [
        f"{path.relative_to(ROOT)}:{function.lineno} {function.name}"
        for path, source, function, _ in every()
        if _arguments(function) > MOST_ARGUMENTS
        and not {KERNELS, CATALOGUE} & {*path.parents}
        and REASON not in source
    ]
    assert found == []


def test_a_class_name_means_one_thing():
    places: dict[str, list[str]] = {}
    for path, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(f"{path.relative_to(ROOT)}:{node.lineno}")
    assert {name: where for name, where in places.items() if len(where) > 1} == {}


def _raised(node: ast.AST) -> Iterator[str]:
    """Names of what is raised in a function: not what a handler of its own catches, nor what is raised again."""
    for inner in ast.iter_child_nodes(node):
        if isinstance(inner, ast.Try):
            caught = " ".join(ast.unparse(each.type) for each in inner.handlers if each.type)
            yield from (name for name in _raised(ast.Module(inner.body, [])) if name not in caught)
            rest = [*inner.handlers, *inner.orelse, *inner.finalbody]
            yield from (name for each in rest for name in _raised(each))
            continue
        if isinstance(inner, ast.Raise) and inner.exc is not None:
            yield ast.unparse(inner.exc).partition("(")[0]
        elif isinstance(inner, ast.Call) and ast.unparse(inner.func) == "require":
            yield "ArgumentError"
        yield from _raised(inner)


@pytest.mark.parametrize("package", ["assessment", "mechanics"])
def test_a_public_function_says_what_it_raises(package):
    found = []
    for path, _, function, about in every():
        public = not function.name.startswith("_") or function.name in {"__init__", "__post_init__"}
        if public and path.relative_to(ROOT).parts[0] == package and any(_raised(function)):
            docstrings = (ast.get_docstring(function) or "") + about
            if "aise" not in docstrings:
                found.append(f"{path.relative_to(ROOT)}:{function.lineno} {function.name}")
    assert found == []


def test_what_a_handler_catches_is_not_raised():
    tree = ast.parse("def f():\n try:\n  raise A('x')\n except A:\n  raise B from None\n raise\n")
    assert list(_raised(tree.body[0])) == ["B"]


def test_assessment_imports_packages_of_mechanics_and_not_their_modules():
    """Types for the checker too; the benchmark looks inside."""
    wrong = [
        f"{path.relative_to(ROOT)}: {node.module}"
        for path, tree in trees().items()
        if path.is_relative_to(ROOT / "assessment") and "benchmark" not in path.parts
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("mechanics.")
        if node.module.count(".") > 1 or node.module in {"mechanics.kernels", "mechanics.solvers"}
    ]
    assert not wrong


def test_what_a_package_promises_is_there():
    for name in ("mechanics", *(f"mechanics.{part}" for part in ("model", "records", "procedures", "steps"))):
        package = importlib.import_module(name)
        assert all(hasattr(package, each) for each in package.__all__)
        assert sorted(package.__all__) == sorted(set(package.__all__))


def test_every_error_of_mechanics_has_one_base():
    found = set()
    for module in pkgutil.walk_packages(mechanics.__path__, "mechanics."):
        found |= {
            each
            for each in vars(importlib.import_module(module.name)).values()
            if isinstance(each, type)
            and issubclass(each, Exception)
            and each.__module__.startswith("mechanics")
        }
    found.remove(SaidError)  # what some of them are besides; it is not raised alone
    assert len(found) > 5
    assert all(issubclass(each, MechanicsError) for each in found)


def test_mechanics_raises_no_plain_errors():
    """A caller that catches MechanicsError catches all that mechanics has to say."""
    plain = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path, tree in trees().items()
        if path.is_relative_to(ROOT / "mechanics")
        for node in ast.walk(tree)
        if isinstance(node, ast.Raise)
        and isinstance(node.exc, ast.Call)
        and isinstance(node.exc.func, ast.Name)
        if node.exc.func.id in {"ValueError", "RuntimeError", "Exception", "TypeError"}
    ]
    assert not plain


CLOCKS = r"perf_counter\(|monotonic\(|time\.time\(|timeout=[\d.]|deadline=[\d.]|\.poll\([\d.]|\.join\([\d.]"


def test_no_time_on_the_wall_is_measured():
    """What hangs is ended by faulthandler_timeout; the clocks of test_benchmark and test_terminal are their own."""
    sources = {*(ROOT / "tests").rglob("*.py")} - {Path(__file__)}
    assert [path for path in sorted(sources) if re.search(CLOCKS, path.read_text(encoding="utf-8"))] == []
