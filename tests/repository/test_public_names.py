"""`assessment` knows `mechanics` by the public names of its packages, and all its errors by one base class."""

from __future__ import annotations

import ast
import importlib
import pkgutil

import mechanics
from mechanics import MechanicsError
from mechanics.messages import SaidError
from tests import ROOT


def test_assessment_imports_packages_of_mechanics_and_not_their_modules():
    """Types for the checker too; the benchmark looks inside."""
    wrong = [
        f"{path.relative_to(ROOT)}: {node.module}"
        for path in sorted((ROOT / "assessment").rglob("*.py"))
        if "benchmark" not in path.parts
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
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
        for path in sorted((ROOT / "mechanics").rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Raise)
        and isinstance(node.exc, ast.Call)
        and isinstance(node.exc.func, ast.Name)
        if node.exc.func.id in {"ValueError", "RuntimeError", "Exception", "TypeError"}
    ]
    assert not plain
