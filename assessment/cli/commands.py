"""The commands: each takes its options and returns its exit code. Imports are late: `--help` answers in 0.3 s."""

from __future__ import annotations

import json
import os
from functools import partial
from typing import TYPE_CHECKING

from assessment.project.catalogue import NAMES
from assessment.runtime.console import say, tell, unwritten
from assessment.runtime.errors import DONE, INCOMPLETE, WRONG_INPUT, error_text

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable
    from pathlib import Path

    from assessment.results.schema import Results
    from assessment.runtime.tasks import Outcome


EXIT_CODES = f"""exit codes:
  {DONE}  done
  {WRONG_INPUT}  the input is wrong: nothing was overwritten
  {INCOMPLETE}  an analysis or the output was not completed, or the run was interrupted: what is finished is kept"""


def incomplete(error: RuntimeError | MemoryError, unchanged: str) -> str | None:
    """Return what kept an analysis from being completed, and what is left; None where the error is a bug."""
    from assessment.runtime.pool import KilledError
    from mechanics import ConvergenceError

    if isinstance(error, ConvergenceError):
        return f"{error}; nothing was written"
    if isinstance(error, KilledError | MemoryError):
        return f"{'memory ran out' if isinstance(error, MemoryError) else error}; {unchanged}"
    return None


def tell_error(error: ValueError | OSError) -> int:
    """Print the message of an error, each of its lines as one; return its exit code."""
    for line in error_text(error).split("\n"):
        tell(f"error: {line}")
    return INCOMPLETE if unwritten(error) else WRONG_INPUT


def run(options: argparse.Namespace) -> int:
    """Carry out the stages and print the summary; INCOMPLETE where an analysis was not completed."""
    from assessment.project.project import load_project
    from assessment.runtime.progress import progress
    from assessment.workflow.run import carry_out, select

    project = select(load_project(options.project), options.only)
    folder = _writable(options.out or project.folder / "output")
    with progress() as show:
        how = (options.jobs, options.fresh, not options.no_report, show, options.scheduler)
        outcome, warnings = carry_out(project, folder, *how)
    say((as_json if options.json else summary)(outcome, folder, warnings))
    return DONE if outcome.complete else INCOMPLETE


def check(options: argparse.Namespace) -> int:
    """Read and validate everything, draw the model, print its summary and every warning; no analysis.

    With `--repair` first write a repaired drawing beside the project's, list every change, and check that one.
    """
    from assessment.project.model import with_repaired_drawing
    from assessment.project.motions import described
    from assessment.project.project import load_project
    from assessment.report.chapters.judgement import model_summary, refuse_unreadable
    from assessment.report.figures.drawing import draw_faults, draw_model, save_svg
    from assessment.report.language import Words
    from assessment.workflow.checking import checked, expected_line
    from mechanics.errors import FaultyDrawingError

    project = load_project(options.project)
    folder = _writable(options.out or project.folder / "output")
    refuse_unreadable(folder)
    drawing, words = folder / "model.svg", Words.of("en")  # as all that the terminal says
    if options.repair:
        project, changes = with_repaired_drawing(project)
        for change in changes:
            say(change)
        name = project.geometry.drawing
        count = "1 change" if len(changes) == 1 else f"{len(changes)} changes"
        wrote = f'{count}: {project.path(name)}; to use it write geometry.drawing = "{name}"'
        say(wrote if changes else f"{name}: nothing that can be repaired")
    try:
        found = checked(project)
    except FaultyDrawingError as faulty:
        tell_error(faulty)
        if faulty.outlines:
            save_svg(partial(draw_faults, faulty, words), drawing)
            tell(f"drawing with the faults marked: {drawing}")
        if any(fault.remedy for fault in faulty.faults) and not options.repair:
            tell("small faults can be repaired in a copy of the drawing: assesto check --repair")
        return WRONG_INPUT
    save_svg(lambda: draw_model(found.results, words), drawing)
    say(model_summary(found.results))
    say(f"drawing of the model: {drawing}")
    for record in found.motions.records:
        say(described(record))
    say(expected_line(found))
    for line in warning_lines(found.warnings):
        say(line)
    return DONE


def status(options: argparse.Namespace) -> int:
    """Print where a run is, how the last one ended, about how long the first takes. Raises ValueError."""
    from assessment.runtime.progress import NOTHING, status_json
    from assessment.runtime.progress import status as as_text

    if not options.project.is_dir():
        raise ValueError(f"{options.project}: no such folder; give the folder of the project")
    said = (status_json if options.json else as_text)(options.out or options.project / "output")
    say(said)
    if said.startswith(NOTHING):
        from assessment.workflow.checking import first_run

        say(first_run(options.project))
    return DONE


def new(options: argparse.Namespace) -> int:
    """Make a project folder from a template, drawing or example, or list them. Raises ValueError for options."""
    from assessment.project.catalogue import new_project as catalogue
    from assessment.project.project import TOML, XLSX

    if options.template is not None:
        options.template = "-".join(options.template.lower().replace("_", " ").split())
    if options.list:
        for name in [options.template] if options.template else NAMES:
            say(f"{name}:")
            for option, (default, unit, description) in catalogue.template_options(name).items():
                say(f"  {option:18} {default:>8g} {unit:6} {description}")
        if options.template is None:
            say("examples:")
            for name, folder in catalogue.examples().items():
                say(f"  {name:18} {catalogue.example_title(folder)}")
        return DONE
    given = [each for each in (options.template, options.example, options.drawing) if each is not None]
    if len(given) != 1:
        what = "more than one given; choose one" if given else "missing; assesto new --list names them"
        raise ValueError(f"--template, --drawing or --example: {what}")
    if options.folder is None:
        raise ValueError("DIR: missing; give the folder to make: assesto new DIR --template NAME")
    source = XLSX if options.excel else TOML
    if options.template is not None:
        dimensions = {}
        for item in options.set:
            key, _, value = item.partition("=")
            try:
                dimensions[key.strip()] = float(value)
            except ValueError:
                raise ValueError(f"--set {item}: not KEY=NUMBER; give for example span_m=6.0") from None
        catalogue.new_project(options.folder, options.template, dimensions, source)
    elif options.set:
        raise ValueError("--set: of a template only; leave it out, or give --template")
    elif options.example is not None:
        catalogue.new_example(options.folder, options.example, source)
    else:
        for line in catalogue.new_from_drawing(options.folder, options.drawing, source):
            say(line)
    say(f"wrote {options.folder}; next: assesto check {options.folder}")
    return DONE


def convert(options: argparse.Namespace) -> int:
    """Write project.toml as project.xlsx, or back."""
    from assessment.project.project import convert as to_other_format
    from assessment.project.project import load_project

    project = load_project(options.project)
    new, kept = to_other_format(project.path(project.source), project.content(defaults=False))
    say(f"wrote {new}; the earlier file is kept as {kept.name}")
    return DONE


def schema(options: argparse.Namespace) -> int:
    """Print the JSON schema of project.toml, or of results.json."""
    if options.results:
        from assessment.results.schema import json_schema
    else:
        from assessment.project.project import json_schema
    say(json.dumps(json_schema(), indent=2))
    return DONE


def report(options: argparse.Namespace) -> int:
    """Render the report again from stored results."""
    from assessment.project.project import load_project
    from assessment.workflow.run import print_again

    project = load_project(options.project)
    folder = _writable(options.out or project.folder / "output")
    for warning in print_again(project, folder):
        tell(f"warning: {warning}")
    pdf = folder / "report.pdf"
    say(f"report: {pdf if pdf.is_file() else pdf.with_suffix('.html')}")
    return DONE


def app(options: argparse.Namespace) -> int:
    """Serve the page of a project until interrupted."""
    from assessment.app.server import serve

    serve(options.project, options.port, not options.no_browser)
    return DONE


def benchmark(options: argparse.Namespace) -> int:
    """Measure run time against error on this machine."""
    from assessment.benchmark.command import benchmark as measure

    folder = _writable(options.out)
    measure(options.names, options.quick, folder)
    say(f"\ntables: {folder}")
    return DONE


def _writable(folder: Path) -> Path:
    """Return the folder if results can be written there: checked before any analysis."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    wrong = "is a file;" if not existing.is_dir() else "no permission to write; change it or"
    if not existing.is_dir() or not os.access(existing, os.W_OK):
        raise ValueError(f"{existing}: {wrong} give another folder with --out DIR")
    return folder


def warning_lines(warnings: Iterable[str]) -> list[str]:
    """Return the warnings as lines, each once."""
    return [f"warning: {text}" for text in dict.fromkeys(warnings)]


def summary(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return a summary of the run: what was found, a table by state and direction, then the warnings."""
    lines = [outcome.told]
    if outcome.taken:
        lines.append(
            f"taken over from earlier runs: {outcome.taken} of {outcome.taken + outcome.computed} analyses, "
            "inputs unchanged (--fresh computes them again)"
        )
    lines.append(f"results: {folder}")
    return "\n".join([*lines, *warning_lines(_warnings(outcome.results, warnings))])


def as_json(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return the summary as one JSON object with the rows of two tables; null: not asked for or not reached."""
    from assessment.report.tables.capacity import verification
    from assessment.report.tables.structure import settlements
    from assessment.results.schema import plain
    from assessment.results.summary import best_of, undetermined

    results = outcome.results
    best = best_of(results.identification) if results.identification else None
    content = {
        "assesto": results.assesto, "title": results.title, "output": str(folder),
        "complete": outcome.complete, "analyses": {"computed": outcome.computed, "taken_over": outcome.taken},
        "model": {key: value for key, value in plain(results.model).items() if key != "warnings"},
        "summary": plain(results.summary), "undetermined": undetermined(results),
        "verification": verification(results).rows, "settlements": settlements(results).rows,
        "worst_scenario": plain(results.scenarios.worst) if results.scenarios else None,
        "comparison": plain(results.comparison),
        "best_movement": plain(best.movement) if best else None, "warnings": _warnings(results, warnings),
        "timing_s": results.timing_s,
    }  # fmt: skip
    return json.dumps(content, allow_nan=False, indent=2)


def _warnings(results: Results, others: Iterable[str]) -> list[str]:
    return [*results.model.warnings, *results.quality.warnings, *others]
