"""The errors that end a command with one message, and the remedies that messages propose."""

import difflib
from collections.abc import Collection, Iterable
from opcode import opmap

DONE, WRONG_INPUT, INCOMPLETE = 0, 2, 3  # exit codes of a run
_MOST_NAMES = 12
RAISE = opmap["RAISE_VARARGS"]  # the instruction of a raise statement
_QUOTED = 120  # characters of a line of the user's file that a message shows


class ProjectError(ValueError):
    """The project cannot be used as it is; one line per problem, `FILE: KEY: what is wrong; what to do`."""


def is_input_error(error: Exception) -> bool:
    """Whether an exception is the user's to mend: one that a `raise` of our own code made, and no bug."""
    if isinstance(error, OSError | ProjectError):
        return True
    from mechanics import ArgumentError, DrawingError, RecordError

    if isinstance(error, DrawingError | RecordError | ArgumentError):
        return True
    last = error.__traceback__
    while last and last.tb_next:
        last = last.tb_next
    if type(error) is not ValueError or last is None:
        return False
    package = last.tb_frame.f_globals["__name__"].partition(".")[0]
    ours = package in {"assessment", "mechanics", "__main__"}
    return ours and last.tb_frame.f_code.co_code[last.tb_lasti] == RAISE


def error_text(error: Exception) -> str:
    """Return what is wrong and what to do, a line per problem, as every way into the program says it."""
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}; change it or choose another place"
    return str(error)


def alike(name: str, valid: Iterable[str]) -> list[str]:
    """Return the valid names that hold one that does not exist as a word, else the nearest, if one is near."""
    by_lower = {each.lower(): each for each in valid}
    holding = [each for low, each in by_lower.items() if name.lower() in low.split("_")]
    near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.5)
    return holding[:_MOST_NAMES] or [by_lower[each] for each in near]


def nearest(name: str, valid: Collection[str]) -> str:
    """Return the remedy for a name that does not exist: those alike, or what is valid."""
    meant = alike(name, valid)
    shown = [f'"{each}"' for each in meant or valid]
    if meant:
        return f"did you mean {' or '.join(shown)}?"
    return f"valid: {', '.join(shown[:_MOST_NAMES])}{', …' if len(shown) > _MOST_NAMES else ''}"


def shortened(text: str, most: int = _QUOTED) -> str:
    """Return a text of the user's in as many characters as a message shows."""
    return text if len(text) <= most else text[: most - 1] + "…"
