"""The command line: assesto run, check, status, new, convert, schema, report, benchmark."""

from __future__ import annotations

import argparse
import json
import logging
import os
import re
import sys
import warnings
from functools import partial
from opcode import opmap
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.runtime.console import prepare, say, tell, visible
from assessment.runtime.garbage import collect_rarely
from assessment.runtime.interruption import interrupted, leave, watch

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any, NoReturn

DONE, WRONG_INPUT, INCOMPLETE = 0, 2, 3
BENCHMARKS = (
    "statics", "dynamics", "ensembles", "dissipation", "collapse", "steps", "growth", "walls", "chain",
    "campaigns", "skips",
)  # fmt: skip
TEMPLATES = ("block", "wall", "arch", "buttressed-arch", "triumphal-arch")
STAGES = (
    "pushdown",
    "pushover",
    "history",
    "incremental",
    "campaign",
    "assessment",
    "scenarios",
    "sensitivity",
)
EXAMPLES = {  # what the help of each command ends with; "": of all of them
    "": ("assesto new arch --template buttressed-arch", "assesto run arch"),
    "run": ("assesto run arch", "assesto run arch --only pushdown,pushover --out trial"),
    "check": ("assesto check arch", "assesto check arch --out trial"),
    "new": (
        "assesto new arch --template buttressed-arch",
        "assesto new wall --template wall --set height_m=4.2",
    ),
    "convert": ("assesto convert arch", "assesto convert ../survey/arch"),
    "schema": ("assesto schema > project.schema.json", "assesto schema --results > results.schema.json"),
    "report": ("assesto report arch", "assesto report arch --out trial"),
    "status": ("assesto status arch", "assesto status arch --out trial"),
    "benchmark": ("assesto benchmark --quick", "assesto benchmark statics steps --out measured"),
}
COMMANDS = tuple(EXAMPLES)[1:]
EXIT_CODES = f"""exit codes:
  {DONE}  done
  {WRONG_INPUT}  the input is wrong: nothing was overwritten
  {INCOMPLETE}  an analysis could not be completed, or the run was interrupted: what is finished is kept"""
RAISE = opmap["RAISE_VARARGS"]  # the instruction of a raise statement


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code: 0 done, 2 wrong input, 3 an analysis could not be completed."""
    whole = arguments is None  # the process is this command
    if whole:
        prepare()
    try:
        options = _options(sys.argv[1:] if arguments is None else arguments)
    except ValueError as error:
        tell(f"error: {error}")
        return WRONG_INPUT
    kept = "; finished analyses are kept: run again to go on" if options.command is _run else ""
    unchanged = f"nothing of an earlier result was changed{kept}"
    if whole:
        watch(f"interrupted: {unchanged}", INCOMPLETE)
        collect_rarely()
        _silence_libraries()
    try:
        code = _carry_out(options)
    except (ValueError, OSError) as error:
        if not _is_input_error(error):
            raise
        _tell(error)
        if options.command is _run and getattr(error, "outlines", None):
            tell("assesto check draws model.svg with the faults marked")
        return WRONG_INPUT
    except (RuntimeError, MemoryError) as error:
        if (cause := _incomplete(error, unchanged)) is None:
            raise
        tell(f"error: {cause}")
        return INCOMPLETE
    except KeyboardInterrupt:
        if whole:
            leave(f"interrupted: {unchanged}", INCOMPLETE)
        tell(f"interrupted: {unchanged}")
        return INCOMPLETE
    return code


def _carry_out(options: argparse.Namespace) -> int:
    """Return the exit code of a command. Raises KeyboardInterrupt for whatever a library makes of an interruption."""
    try:
        code: int = options.command(options)
    except Exception as error:
        if interrupted():
            raise KeyboardInterrupt from error
        raise
    return code


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options of a command.

    Raises ValueError, with the nearest name that there is, for a command or an option that there is not.
    """
    name = next((text for text in arguments if not text.startswith("-")), None)
    if name is not None and name not in COMMANDS:
        raise ValueError(f"assesto {name}: no such command; {_nearest(name, COMMANDS)}")
    options, unknown = _parser().parse_known_args(arguments)
    if unknown:
        wrong = unknown[0].partition("=")[0]
        known = re.findall(r"--[a-z-]+", options.parser.format_usage())
        if wrong.startswith("-"):
            raise ValueError(f"assesto {name}: {wrong}: no such option; {_nearest(wrong, known)}")
        raise ValueError(f"assesto {name}: {wrong}: one argument too many; see assesto {name} --help")
    return options


def _nearest(name: str, valid: Sequence[str]) -> str:
    from assessment.runtime.errors import nearest  # late: it takes as long to import as all of --help

    return nearest(name, valid)


def _silence_libraries() -> None:
    """Keep what libraries warn of and log, with the user's names in it, off the terminal, of other processes too."""
    logging.getLogger().addHandler(logging.NullHandler())
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
        os.environ.setdefault("PYTHONWARNINGS", "ignore")


class _Parser(argparse.ArgumentParser):
    """A parser that shows arguments as they are and does nothing else with them."""

    def error(self, message: str) -> NoReturn:
        super().error(visible(message))


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="assesto",
        description="Seismic capacity of dry-joint masonry before and after foundation settlements.",
        **_end(""),
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and stop")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="name")

    run = commands.add_parser(
        "run", help="run every stage the project asks for and write its report", **_end("run")
    )
    _add_project(run, "the results")
    run.add_argument(
        "--only",
        type=lambda text: text.split(","),
        metavar="STAGE,…",
        help=f"only these stages, with what they need: {', '.join(STAGES)}",
    )
    run.add_argument(
        "--jobs", type=_jobs, default=0, metavar="N", help="processes (default: as many as help)"
    )
    run.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="a running Dask cluster that computes instead, such as tcp://host:8786",
    )
    run.add_argument("--no-report", action="store_true", help="numbers, tables and figures only")
    run.add_argument(
        "--fresh", action="store_true", help="compute again what an earlier run has already computed"
    )
    run.add_argument("--json", action="store_true", help="print the summary as JSON")
    run.set_defaults(command=_run)

    check = commands.add_parser(
        "check", help="read and validate everything, draw the model; no analysis", **_end("check")
    )
    _add_project(check, "model.svg")
    check.set_defaults(command=_check)

    status = commands.add_parser(
        "status", help="tell what a run under way is at, what failed, and how long it takes", **_end("status")
    )
    _add_project(status, "the results")
    status.set_defaults(command=_status)

    new = commands.add_parser("new", help="make a new project folder from a template", **_end("new"))
    new.add_argument("folder", type=_folder, metavar="DIR", nargs="?", help="the folder to make")
    new.add_argument("--template", metavar="NAME", help=", ".join(TEMPLATES))
    new.add_argument(
        "--set", action="append", default=[], metavar="KEY=NUMBER", help="a dimension; see --list"
    )
    new.add_argument("--excel", action="store_true", help="write project.xlsx instead of project.toml")
    new.add_argument(
        "--list", action="store_true", help="print the dimensions of the template, or of all, and stop"
    )
    new.set_defaults(command=_new)

    convert = commands.add_parser(
        "convert", help="turn project.toml into project.xlsx, or back", **_end("convert")
    )
    _add_project(convert)
    convert.set_defaults(command=_convert)

    schema = commands.add_parser(
        "schema",
        help="print the JSON schema of project.toml, for editors, or of results.json",
        **_end("schema"),
    )
    schema.add_argument("--results", action="store_true", help="that of results.json")
    schema.set_defaults(command=_schema)

    report = commands.add_parser(
        "report", help="render the report again from stored results", **_end("report")
    )
    _add_project(report, "the results")
    report.set_defaults(command=_report)

    benchmark = commands.add_parser(
        "benchmark", help="measure run time against error on this machine", **_end("benchmark")
    )
    benchmark.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(BENCHMARKS)} (default: all)")
    benchmark.add_argument("--quick", action="store_true", help="fewer and smaller cases: a minute or so")
    benchmark.add_argument(
        "--out",
        type=_folder,
        default=Path("benchmark"),
        metavar="DIR",
        help="folder of tables, plots and summary.md (default: benchmark)",
    )
    benchmark.set_defaults(command=_benchmark)
    for command in commands.choices.values():
        command.set_defaults(parser=command)
    return parser


def _end(command: str) -> dict[str, Any]:
    """How the help of a command ends: two examples and the exit codes."""
    shown = "\n".join(f"  {example}" for example in EXAMPLES[command])
    return {
        "epilog": f"examples:\n{shown}\n\n{EXIT_CODES}",
        "formatter_class": argparse.RawDescriptionHelpFormatter,
    }


class _Version(argparse.Action):
    """Print the installed version; looked up only when asked for, which keeps --help quick."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        print(f"{parser.prog} {version('assesto')}")
        parser.exit()


def _add_project(command: argparse.ArgumentParser, written: str = "") -> None:
    """Add PROJECT and, where something is `written`, the folder that it goes to."""
    command.add_argument(
        "project", type=_folder, metavar="PROJECT", help="folder that holds project.toml or project.xlsx"
    )
    if written:
        where = f"folder of {written} (default: PROJECT/output)"
        command.add_argument("--out", type=_folder, metavar="DIR", help=where)


def _folder(text: str) -> Path:
    """Return the folder that an argument names; an empty one would be the folder the command is given in."""
    if not text:
        raise argparse.ArgumentTypeError("is empty; give the name of a folder")
    return Path(text)


def _jobs(text: str) -> int:
    """Return a number of processes, one or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no number of processes; write 1 or more, or leave it out"
        )
    return int(text)


def _run(options: argparse.Namespace) -> int:
    from assessment.project.project import load_project
    from assessment.runtime.progress import as_json, progress, summary
    from assessment.workflow.run import carry_out
    from assessment.workflow.selection import select

    project = select(load_project(options.project), options.only)
    folder = _writable(options.out or project.folder / "output")
    with progress() as show:
        outcome, warnings = carry_out(
            project,
            folder,
            options.jobs,
            options.fresh,
            not options.no_report,
            show,
            options.scheduler,
        )
    say((as_json if options.json else summary)(outcome, folder, warnings))
    return DONE if outcome.complete else INCOMPLETE


def _check(options: argparse.Namespace) -> int:
    from assessment.analyses.checks.demand import demand_spectra
    from assessment.analyses.static.paths import stand
    from assessment.project.model import build_model
    from assessment.project.plausibility import implausible_hazard
    from assessment.project.project import load_project
    from assessment.report.figures.faults import draw_faults
    from assessment.report.figures.model import draw_model
    from assessment.report.figures.style import save_svg
    from assessment.report.text.language import Words, words_of
    from assessment.runtime.progress import model_summary, told
    from assessment.workflow.dynamic import read_motions
    from assessment.workflow.skeleton import describe
    from mechanics.faults import FaultyDrawingError

    project = load_project(options.project)
    folder = _writable(options.out or project.folder / "output")
    drawing = folder / "model.svg"
    try:
        model = build_model(project)
    except FaultyDrawingError as faulty:
        _tell(faulty)
        if faulty.outlines:
            save_svg(partial(draw_faults, faulty, Words.of(project.report.language)), drawing)
            tell(f"drawing with the faults marked: {drawing}")
        return WRONG_INPUT
    results = describe(project, model)
    motions = read_motions(project)
    results["model"]["warnings"] += motions.notes
    if project.assessment:
        demands, _ = demand_spectra(project, motions.history)  # refused here if a run would refuse it
        results["model"]["warnings"] += implausible_hazard(project, demands)
    if unstable := stand(model.assembly):
        results["model"]["self_weight_stable"] = False
        results["model"]["warnings"].append(unstable)
    save_svg(lambda: draw_model(results, words_of(results)), drawing)
    say(model_summary(results))
    say(f"drawing of the model: {drawing}")
    for line in told(results["model"]["warnings"]):
        say(line)
    return DONE


def _status(options: argparse.Namespace) -> int:
    from assessment.runtime.status import status

    if not options.project.is_dir():
        raise ValueError(f"{options.project}: no such folder; give the folder of the project")
    say(status(options.out or options.project / "output"))
    return DONE


def _new(options: argparse.Namespace) -> int:
    from assessment.project.catalogue.new_project import new_project, template_options
    from assessment.project.formats.convert import TOML, XLSX

    if options.list:
        for template in [options.template] if options.template else TEMPLATES:
            say(f"{template}:")
            for name, (default, unit, description) in template_options(template).items():
                say(f"  {name:18} {default:>8g} {unit:6} {description}")
        return DONE
    if options.template is None:
        raise ValueError(f"--template: missing; choose from {', '.join(TEMPLATES)}")
    if options.folder is None:
        raise ValueError(
            f"DIR: missing; give the folder to make: assesto new DIR --template {options.template}"
        )
    given = {}
    for item in options.set:
        key, _, value = item.partition("=")
        try:
            given[key.strip()] = float(value)
        except ValueError:
            raise ValueError(f"--set {item}: not KEY=NUMBER; give for example span_m=6.0") from None
    new_project(options.folder, options.template, given, XLSX if options.excel else TOML)
    say(f"wrote {options.folder}; next: assesto check {options.folder}")
    return DONE


def _convert(options: argparse.Namespace) -> int:
    from assessment.project.formats.convert import convert
    from assessment.project.project import load_project

    new, kept = convert(load_project(options.project))
    say(f"wrote {new}; the earlier file is kept as {kept.name}")
    return DONE


def _schema(options: argparse.Namespace) -> int:
    if options.results:
        from assessment.results.schema import json_schema
    else:
        from assessment.project.project import json_schema
    say(json.dumps(json_schema(), indent=2))
    return DONE


def _report(options: argparse.Namespace) -> int:
    from assessment.project.project import load_project
    from assessment.workflow.run import print_again

    project = load_project(options.project)
    folder = _writable(options.out or project.folder / "output")
    for warning in print_again(project, folder):
        tell(f"warning: {warning}")
    say(f"report: {folder / 'report.html'}")
    return DONE


def _benchmark(options: argparse.Namespace) -> int:
    from assessment.benchmark.command import benchmark

    folder = _writable(options.out)
    benchmark(options.names, options.quick, folder)
    say(f"\ntables and plots: {folder}")
    return DONE


def _writable(folder: Path) -> Path:
    """The folder, if results can be written there: asked before any analysis."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise ValueError(f"{existing}: is a file; give another folder with --out DIR")
    if not os.access(existing, os.W_OK):
        raise ValueError(
            f"{existing}: no permission to write; change it or give another folder with --out DIR"
        )
    return folder


def _incomplete(error: RuntimeError | MemoryError, unchanged: str) -> str | None:
    """Return what kept an analysis from being completed, and what is left; None where the error is a bug."""
    from assessment.runtime.pool import KilledError
    from mechanics import ConvergenceError

    if isinstance(error, ConvergenceError):
        return f"{error}; nothing was written"
    if isinstance(error, KilledError | MemoryError):
        return f"{'memory ran out' if isinstance(error, MemoryError) else error}; {unchanged}"
    return None


def _is_input_error(error: ValueError | OSError) -> bool:
    """Whether an exception is the user's to mend: those that name what is wrong; any other one is a bug.

    A plain ValueError names it where a `raise` of our own code made it; one out of a library, or out of Python itself
    (int of a NaN), is a bug of ours.
    """
    from assessment.runtime.errors import ProjectError
    from mechanics import ArgumentError, DrawingError, RecordError

    if isinstance(error, ProjectError | DrawingError | RecordError | ArgumentError | OSError):
        return True
    last = error.__traceback__
    while last and last.tb_next:
        last = last.tb_next
    if type(error) is not ValueError or last is None:
        return False
    package = last.tb_frame.f_globals["__name__"].partition(".")[0]
    ours = package in {"assessment", "mechanics", "__main__"}
    return ours and last.tb_frame.f_code.co_code[last.tb_lasti] == RAISE


def _tell(error: ValueError | OSError) -> None:
    for line in _message(error).split("\n"):
        tell(f"error: {line}")


def _message(error: ValueError | OSError) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}; change it or choose another place"
    return str(error)
