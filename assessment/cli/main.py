"""The command line: the arguments of the commands, their help, what is misspelt, and what comes of an error."""

from __future__ import annotations

import argparse
import logging
import os
import re
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from assessment.cli import commands
from assessment.cli.commands import EXIT_CODES, incomplete, tell_error
from assessment.project.catalogue import NAMES
from assessment.runtime.console import collect_rarely, interrupted, leave, prepare, say, tell, watch
from assessment.runtime.errors import INCOMPLETE, WRONG_INPUT, is_input_error, nearest
from assessment.runtime.progress import BusyError, record_exit
from assessment.workflow import STAGES
from mechanics.progress import before_compiling

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import NoReturn

    from _typeshed import SupportsWrite

BENCHMARKS = ("statics", "dynamics", "ensembles", "steps", "walls", "chain", "sliding")
EXAMPLES = ("assesto new arch --template buttressed-arch", "assesto run arch")
Argument = tuple[str, dict[str, Any]]


def options_of(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options of a command. Raises ValueError, with the nearest name, for one that there is not."""
    name = next((text for text in arguments if not text.startswith("-")), None)
    if name is not None and name not in COMMANDS:
        raise ValueError(f"assesto {name}: no such command; {nearest(name, COMMANDS)}")
    options, unknown = _parser().parse_known_args(arguments)
    if unknown:
        wrong = unknown[0].partition("=")[0]
        known = re.findall(r"--[a-z-]+", options.parser.format_usage())
        if wrong.startswith("-"):
            raise ValueError(f"assesto {name}: {wrong}: no such option; {nearest(wrong, known)}")
        raise ValueError(f"assesto {name}: {wrong}: one argument too many; see assesto {name} --help")
    return options


class _Parser(argparse.ArgumentParser):
    """A parser that shows arguments as they are and does nothing else with them."""

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """Print the help as every other text; argparse's own way hides that it could not be written."""
        say(self.format_help(), end="")

    def error(self, message: str) -> NoReturn:
        """Print what is missing or wrong in the form of every other message, and where to look it up."""
        tell(f"error: {self.prog}: {message}; see {self.prog} --help")
        self.exit(WRONG_INPUT)


class _Version(argparse.Action):
    """Print the installed version; looked up only when asked for, which keeps --help quick."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        say(f"{parser.prog} {version('assesto')}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    # the documentation is in it where it is installed, beside it in a checkout
    package = Path(__file__).parents[1]
    docs = package / "docs" if (package / "docs").is_dir() else package.parent / "docs"
    what = "Seismic capacity of dry-joint masonry before and after foundation settlements."
    parser = _Parser(prog="assesto", description=what, **_end(EXAMPLES))
    parser.epilog = f"{parser.epilog}\n\ndocumentation: {docs / 'index.md'}"
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and stop")
    parsers = parser.add_subparsers(required=True, metavar="COMMAND", dest="name")
    for name, each in COMMANDS.items():
        own = parsers.add_parser(name, help=each.what, **_end(each.examples))
        own.set_defaults(command=each.carry_out, parser=own)
        for argument, more in each.arguments:
            own.add_argument(argument, **more)
    return parser


def _end(examples: Sequence[str]) -> dict[str, Any]:
    """How the help of a command ends: its examples and the exit codes."""
    shown = "\n".join(f"  {example}" for example in examples)
    end = f"examples:\n{shown}\n\n{EXIT_CODES}"
    return {"epilog": end, "formatter_class": argparse.RawDescriptionHelpFormatter}


def _named(kind: Callable[[str], Any], remedy: str) -> Callable[[str], Any]:
    """Return what reads a name: an empty one would be the folder that the command is given in, or no scheduler."""

    def read(text: str) -> Any:
        if not text:
            raise argparse.ArgumentTypeError(f"is empty; give {remedy}")
        return kind(text)

    return read


_folder = _named(Path, "the name of a folder")


def _whole(what: str, least: int, most: float) -> Callable[[str], int]:

    def read(text: str) -> int:
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is no {what}, or leave it out")
        return int(text)

    return read


def _flag(name: str, what: str) -> Argument:
    return name, {"action": "store_true", "help": what}


def _out(written: str) -> Argument:
    return "--out", {
        "type": _folder, "metavar": "DIR", "help": f"folder of {written} (default: PROJECT/output)",
    }  # fmt: skip


_PROJECT: Argument = ("project", {
    "type": _folder, "metavar": "PROJECT", "help": "folder that holds project.toml or project.xlsx",
})  # fmt: skip


class Command(NamedTuple):
    """What is carried out, what it does, two or more examples, and its arguments."""

    carry_out: Callable[[argparse.Namespace], int]
    what: str
    examples: tuple[str, ...]
    arguments: tuple[Argument, ...]


COMMANDS = {
    "run": Command(
        commands.run, "run every stage the project asks for and write its report",
        ("assesto run arch", "assesto run arch --only pushdown,pushover --out trial"),
        (
            _PROJECT, _out("the results"),
            ("--only", {
                "type": lambda text: text.split(","), "metavar": "STAGE,…",
                "help": f"only these stages, with what they need: {', '.join(STAGES)}",
            }),
            ("--jobs", {
                "type": _whole("number of processes; write 1 or more", 1, float("inf")), "default": 0, "metavar": "N",
                "help": "processes at once (default: one per core if the work is worth starting them)",
            }),
            ("--scheduler", {
                "type": _named(str, "an address such as tcp://host:8786, or leave it out"), "metavar": "ADDRESS",
                "help": "a running Dask cluster that computes instead, such as tcp://host:8786",
            }),
            _flag("--no-report", "numbers, tables and figures only"),
            _flag("--fresh", "compute again what an earlier run has already computed"),
            _flag("--json", "print the summary as JSON"),
        ),
    ),
    "check": Command(
        commands.check, "read and validate everything, draw the model; no analysis",
        ("assesto check arch", "assesto check arch --repair"),
        (_PROJECT, _out("model.svg"), _flag(
            "--repair", "write a repaired drawing beside the original, and check that; lists every change"
        )),
    ),
    "status": Command(
        commands.status, "show what a run is at, what failed and how long it takes, or how the last one ended",
        ("assesto status arch", "assesto status arch --json"),
        (_PROJECT, _out("the results"), _flag("--json", "print it as JSON")),
    ),
    "new": Command(
        commands.new, "make a new project folder from a template, a drawing or an example",
        (
            "assesto new arch --template buttressed-arch", "assesto new wall --template wall --set courses=12",
            "assesto new panel --example tuff_panel", "assesto new church --drawing survey.dxf",
        ),
        (
            ("folder", {"type": _folder, "metavar": "DIR", "nargs": "?", "help": "the folder to make"}),
            ("--template", {"metavar": "NAME", "help": ", ".join(NAMES)}),
            ("--example", {"metavar": "NAME", "help": "an example project; see --list"}),
            ("--set", {
                "action": "append", "default": [], "metavar": "KEY=NUMBER", "help": "a dimension; see --list",
            }),
            ("--drawing", {
                "type": _folder, "metavar": "FILE.dxf",
                "help": "a drawing of one's own: unit, supports and layers without masonry are proposed",
            }),
            _flag("--excel", "write project.xlsx instead of project.toml"),
            _flag("--list", "print the dimensions of the template, or of all with the examples, and stop"),
        ),
    ),
    "convert": Command(
        commands.convert, "turn project.toml into project.xlsx, or back",
        ("assesto convert arch", "assesto convert ../survey/arch"), (_PROJECT,),
    ),
    "schema": Command(
        commands.schema, "print the JSON schema of project.toml, for editors, or of results.json",
        ("assesto schema > project.schema.json", "assesto schema --results > results.schema.json"),
        (_flag("--results", "that of results.json"),),
    ),
    "report": Command(
        commands.report, "render the report again from stored results",
        ("assesto report arch", "assesto report arch --out trial"), (_PROJECT, _out("the results")),
    ),
    "app": Command(
        commands.app, "show the project in the browser, on this machine alone",
        ("assesto app arch", "assesto app"),
        (
            ("project", {
                "type": _folder, "metavar": "PROJECT", "nargs": "?", "help": "default: none, choose there",
            }),
            ("--port", {
                "type": _whole("port; write 1 to 65535", 0, 65535), "default": 0, "metavar": "N",
                "help": "of 127.0.0.1 (default: one that is free)",
            }),
            _flag("--no-browser", "print the address and open no browser"),
        ),
    ),
    "benchmark": Command(
        commands.benchmark, "measure run time against error on this machine",
        ("assesto benchmark --quick", "assesto benchmark statics steps --out measured"),
        (
            ("names", {"nargs": "*", "metavar": "NAME", "help": f"{', '.join(BENCHMARKS)} (default: all)"}),
            _flag("--quick", "fewer and smaller cases: a minute or so"),
            ("--out", {
                "type": _folder, "default": Path("benchmark"), "metavar": "DIR",
                "help": "folder of tables and summary.md (default: benchmark)",
            }),
        ),
    ),
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code: 0 done, 2 wrong input, 3 an analysis could not be completed."""
    whole = arguments is None  # the process is this command
    if whole:
        prepare()
    try:
        options = options_of(sys.argv[1:] if arguments is None else arguments)
    except ValueError as error:
        tell(f"error: {error}")  # a name that has lines is no message of several
        return WRONG_INPUT
    except OSError as error:
        return tell_error(error)
    running = options.command is commands.run
    kept = "; finished analyses are kept: run again to go on" if running else ""
    unchanged = f"nothing of an earlier result was changed{kept}"

    def record(code: int) -> None:
        """Leave the exit code of a run in the journal of its folder, where `assesto status` finds it."""
        if running:
            record_exit(options.out or options.project / "output", code)

    if whole:
        watch(f"interrupted: {unchanged}", INCOMPLETE, lambda: record(INCOMPLETE))
        collect_rarely()
        before_compiling(lambda: tell("compiling, for later commands too: up to a minute"))
        # what libraries warn of and log, with the user's names in it, stays off the terminal, of other processes too
        logging.getLogger().addHandler(logging.NullHandler())
        if not sys.warnoptions:
            warnings.simplefilter("ignore")
            os.environ.setdefault("PYTHONWARNINGS", "ignore")
    try:
        code = _carry_out(options)
    except BusyError as error:
        return tell_error(error)  # the journal is that of the other run
    except (ValueError, OSError) as error:
        if not is_input_error(error):
            raise
        code = tell_error(error)
        if running and getattr(error, "outlines", None):
            tell("assesto check draws model.svg with the faults marked")
    except (RuntimeError, MemoryError) as error:
        if (cause := incomplete(error, unchanged)) is None:
            raise
        tell(f"error: {cause}")
        code = INCOMPLETE
    except KeyboardInterrupt:
        record(INCOMPLETE)
        if whole:
            leave(f"interrupted: {unchanged}", INCOMPLETE)
        tell(f"interrupted: {unchanged}")
        return INCOMPLETE
    record(code)
    return code


def _carry_out(options: argparse.Namespace) -> int:
    """Return the exit code of a command. Raises KeyboardInterrupt where a library made an error of an interruption.

    Raises ValueError where the folder that the command is given in is gone: relative paths mean nothing.
    """
    try:
        Path.cwd()
    except OSError:
        text = "the folder that the command is given in is gone; change to another one (cd)"
        raise ValueError(text) from None
    try:
        code: int = options.command(options)
    except Exception as error:  # a library may make any error of an interruption
        if interrupted():
            raise KeyboardInterrupt from error
        raise
    return code
