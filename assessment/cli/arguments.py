"""The arguments of the commands, their help, and suggestions for what is misspelt."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.cli import commands
from assessment.cli.commands import TEMPLATES
from assessment.cli.exit_codes import EXIT_CODES, WRONG_INPUT
from assessment.runtime.terminal.console import say, tell

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any, NoReturn

    from _typeshed import SupportsWrite

    Parsers = argparse._SubParsersAction["_Parser"]

BENCHMARKS = (
    "statics", "dynamics", "ensembles", "dissipation", "collapse", "steps", "growth", "walls", "chain",
    "campaigns", "sliding", "app", "skips",
)  # fmt: skip
STAGES = (
    "pushdown",
    "pushover",
    "history",
    "incremental",
    "campaign",
    "assessment",
    "scenarios",
    "sensitivity",
    "identification",
)
EXAMPLES = {  # what the help of each command ends with; "": of all of them
    "": ("assesto new arch --template buttressed-arch", "assesto run arch"),
    "run": ("assesto run arch", "assesto run arch --only pushdown,pushover --out trial"),
    "check": ("assesto check arch", "assesto check arch --repair"),
    "new": (
        "assesto new arch --template buttressed-arch",
        "assesto new wall --template wall --set courses=12",
        "assesto new panel --example tuff_panel",
        "assesto new church --drawing survey.dxf",
    ),
    "convert": ("assesto convert arch", "assesto convert ../survey/arch"),
    "schema": ("assesto schema > project.schema.json", "assesto schema --results > results.schema.json"),
    "report": ("assesto report arch", "assesto report arch --out trial"),
    "app": ("assesto app arch", "assesto app"),
    "status": ("assesto status arch", "assesto status arch --json"),
    "benchmark": ("assesto benchmark --quick", "assesto benchmark statics steps --out measured"),
}
COMMANDS = tuple(EXAMPLES)[1:]


def options_of(arguments: Sequence[str]) -> argparse.Namespace:
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


class _Parser(argparse.ArgumentParser):
    """A parser that shows arguments as they are and does nothing else with them."""

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """Print the help as every other text; argparse's own way hides that it could not be written."""
        say(self.format_help(), end="")

    def error(self, message: str) -> NoReturn:
        """Print what is missing or wrong in the form of every other message, and where to look it up."""
        tell(f"error: {self.prog}: {message}; see {self.prog} --help")
        self.exit(WRONG_INPUT)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="assesto",
        description="Seismic capacity of dry-joint masonry before and after foundation settlements.",
        **_end(""),
    )
    parser.epilog = f"{parser.epilog}\n\ndocumentation: {_docs() / 'index.md'}"
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and stop")
    parsers = parser.add_subparsers(required=True, metavar="COMMAND", dest="name")
    for add in (_run, _check, _status, _new, _convert, _schema, _report, _app, _benchmark):
        add(parsers)
    return parser


def _docs() -> Path:
    """Return the folder of the documentation: within the package where it is installed, beside it in a checkout."""
    package = Path(__file__).parents[1]
    return package / "docs" if (package / "docs").is_dir() else package.parent / "docs"


def _run(parsers: Parsers) -> None:
    parser = _added(parsers, "run", commands.run, "run every stage the project asks for and write its report")
    _add_project(parser, "the results")
    parser.add_argument(
        "--only",
        type=lambda text: text.split(","),
        metavar="STAGE,…",
        help=f"only these stages, with what they need: {', '.join(STAGES)}",
    )
    jobs = "processes at once (default: one per core if the work is worth starting them)"
    parser.add_argument("--jobs", type=_jobs, default=0, metavar="N", help=jobs)
    scheduler = "a running Dask cluster that computes instead, such as tcp://host:8786"
    parser.add_argument("--scheduler", type=_address, metavar="ADDRESS", help=scheduler)
    _add_flag(parser, "--no-report", "numbers, tables and figures only")
    _add_flag(parser, "--fresh", "compute again what an earlier run has already computed")
    _add_flag(parser, "--json", "print the summary as JSON")


def _check(parsers: Parsers) -> None:
    what = "read and validate everything, draw the model; no analysis"
    parser = _added(parsers, "check", commands.check, what)
    _add_project(parser, "model.svg")
    _add_flag(
        parser, "--repair", "write a repaired drawing beside the original, and check that; lists every change"
    )


def _status(parsers: Parsers) -> None:
    what = "tell what a run is at, what failed and how long it takes, or how the last one ended"
    parser = _added(parsers, "status", commands.status, what)
    _add_project(parser, "the results")
    _add_flag(parser, "--json", "print it as JSON")


def _new(parsers: Parsers) -> None:
    parser = _added(
        parsers, "new", commands.new, "make a new project folder from a template, a drawing or an example"
    )
    parser.add_argument("folder", type=_folder, metavar="DIR", nargs="?", help="the folder to make")
    parser.add_argument("--template", metavar="NAME", help=", ".join(TEMPLATES))
    parser.add_argument("--example", metavar="NAME", help="an example project; see --list")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=NUMBER", help="a dimension; see --list"
    )
    drawing = "a drawing of one's own: unit, supports and layers without masonry are proposed"
    parser.add_argument("--drawing", type=_folder, metavar="FILE.dxf", help=drawing)
    _add_flag(parser, "--excel", "write project.xlsx instead of project.toml")
    _add_flag(parser, "--list", "print the dimensions of the template, or of all with the examples, and stop")


def _convert(parsers: Parsers) -> None:
    _add_project(_added(parsers, "convert", commands.convert, "turn project.toml into project.xlsx, or back"))


def _schema(parsers: Parsers) -> None:
    what = "print the JSON schema of project.toml, for editors, or of results.json"
    _add_flag(_added(parsers, "schema", commands.schema, what), "--results", "that of results.json")


def _report(parsers: Parsers) -> None:
    what = "render the report again from stored results"
    _add_project(_added(parsers, "report", commands.report, what), "the results")


def _app(parsers: Parsers) -> None:
    parser = _added(parsers, "app", commands.app, "show the project in the browser, on this machine alone")
    parser.add_argument(
        "project", type=_folder, metavar="PROJECT", nargs="?", help="default: none, choose there"
    )
    port = "of 127.0.0.1 (default: one that is free)"
    parser.add_argument("--port", type=_port, default=0, metavar="N", help=port)
    _add_flag(parser, "--no-browser", "print the address and open no browser")


def _benchmark(parsers: Parsers) -> None:
    what = "measure run time against error on this machine"
    parser = _added(parsers, "benchmark", commands.benchmark, what)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(BENCHMARKS)} (default: all)")
    _add_flag(parser, "--quick", "fewer and smaller cases: a minute or so")
    where = "folder of tables, plots and summary.md (default: benchmark)"
    parser.add_argument("--out", type=_folder, default=Path("benchmark"), metavar="DIR", help=where)


def _added(
    parsers: Parsers, name: str, command: Callable[[argparse.Namespace], int], what: str
) -> argparse.ArgumentParser:
    """Add a command and return its parser; `what`: what it does, for the list of all."""
    parser: argparse.ArgumentParser = parsers.add_parser(name, help=what, **_end(name))
    parser.set_defaults(command=command, parser=parser)
    return parser


def _add_flag(parser: argparse.ArgumentParser, name: str, what: str) -> None:
    """Add an option without a value; `what` it does."""
    parser.add_argument(name, action="store_true", help=what)


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

        say(f"{parser.prog} {version('assesto')}")
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


def _address(text: str) -> str:
    """Return the address of a scheduler; with an empty one the run would do without."""
    if not text:
        raise argparse.ArgumentTypeError("is empty; give an address such as tcp://host:8786, or leave it out")
    return text


def _port(text: str) -> int:
    """Return the number of a port."""
    if not text.isdecimal() or not 0 <= int(text) < 65536:
        raise argparse.ArgumentTypeError(f"{text!r} is no port; write 1 to 65535, or leave it out")
    return int(text)


def _jobs(text: str) -> int:
    """Return a number of processes, one or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no number of processes; write 1 or more, or leave it out"
        )
    return int(text)
