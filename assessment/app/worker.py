"""The process that computes what the page shows while it is edited: ended where it takes too long, and begun anew."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.runtime.errors import ProjectError, error_text, is_input_error

if TYPE_CHECKING:
    from assessment.project.model import ProjectModel
    from mechanics import Following

LIMITS = {"model": 120.0, "live": 120.0, "repair": 300.0}  # s, of an answer
LIMIT = 60.0  # s, of the others
OPEN = 1e-4  # of the size of a block: a joint is open that has opened by more
BUDGET = 0.04  # s, of following the pointer before an answer: 20 a second, where an increment takes less


class WorkerError(RuntimeError):
    """The worker met a bug, or was ended: its last line says what, those before where."""


class Worker:
    """A process that answers one question at a time; it begins with the first one."""

    def __init__(self, limits: Mapping[str, float] = LIMITS) -> None:
        self.limits, self.turn = limits, threading.Lock()
        self.process: multiprocessing.process.BaseProcess | None = None
        self.connection: Any = None

    def ask(self, question: str, /, **arguments: Any) -> Any:
        """Return the answer to a question. Raises ProjectError for what is the user's to mend, WorkerError else."""
        with self.turn:
            self.begin()
            try:
                self.connection.send((question, arguments))
                if not self.connection.poll(limit := self.limits.get(question, LIMIT)):
                    self.end()
                    raise ProjectError(
                        f"{question}: not answered within {limit:g} s; the drawing may be too large for this "
                        "page, the command line has no limit"
                    )
                kind, answer = self.connection.recv()
            except (EOFError, OSError):
                self.end()
                raise WorkerError("the process that draws was ended from outside; it begins anew") from None
        if kind == "wrong":
            raise ProjectError(answer)
        if kind == "fault":
            raise WorkerError(answer)
        return answer

    def begin(self) -> None:
        """Start the process where there is none."""
        if self.process is None or not self.process.is_alive():
            context = multiprocessing.get_context("spawn")
            self.connection, theirs = context.Pipe()
            self.process = context.Process(target=_work, args=(theirs,), daemon=True)
            self.process.start()
            theirs.close()

    def end(self) -> None:
        """End the process; whatever it is at is lost, and nothing else."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.connection.close()
            self.process = None


def _work(connection: Connection) -> None:
    """Answer questions until there is nobody who asks any."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this process
    from assessment.app import pictures
    from assessment.project.catalogue.new_project import example_title, examples, new_example, new_project
    from assessment.report.chapters.judgement import read_judgement

    live = Live()
    questions: dict[str, Callable[..., Any]] = {
        "model": pictures.model_picture,
        "repair": pictures.repair_picture,
        "drawing": pictures.drawing_picture,
        "record": pictures.record_picture,
        "grid": pictures.grid_picture,
        "picture": pictures.attachment_picture,
        "spectrum": pictures.spectrum_picture,
        "live": live.answer,
        "template": partial(new_project, options={}),
        "example": new_example,
        "examples": lambda: {name: example_title(folder) for name, folder in examples().items()},
        "begin": pictures.begin_project,
        "judgement": read_judgement,
    }
    while True:
        try:
            name, arguments = connection.recv()
        except (EOFError, OSError):
            return
        try:
            connection.send(("done", questions[name](**arguments)))
        except Exception as error:  # a bug in one answer: the process goes on
            wrong = is_input_error(error)
            connection.send(("wrong", error_text(error)) if wrong else ("fault", traceback.format_exc()))


class Live:
    """The structure that follows a support under the pointer."""

    def __init__(self) -> None:
        self.key: tuple[str, str] | None = None
        self.built: tuple[str, ProjectModel] | None = None
        self.follow: Following | None = None

    def answer(
        self, folder: Path, tag: str, support: str, target: Sequence[float], home: bool = False,
        whole: bool = False,
    ) -> dict[str, Any]:  # fmt: skip
        """Follow a support towards `target` (x, z, m, and rotation, rad) for BUDGET; return where everything is.

        `tag`: by which the model is known; the support goes on from where it is, or with `home` from the drawing.
        `whole`: from the drawing straight to the target, in the increments of the project. `there`: whether it has
        arrived; `cost` (s): of an increment. Raises ProjectError where the structure does not stand as drawn.
        """
        from mechanics import MechanicsError

        try:
            if self.follow is None or self.key != (tag, support) or home or whole:
                self.follow, self.key = self._begun(folder, tag, support, whole), (tag, support)
            follow, began, steps, more = self.follow, time.perf_counter(), 0, True
            (follow.to if whole else follow.aim)(target[:2], target[2])
            while more and (
                whole or steps == 0 or (steps + 1) / steps * (time.perf_counter() - began) < BUDGET
            ):
                more, steps = follow.advance(), steps + 1
            if whole:
                follow.release()
        except MechanicsError as error:
            raise ProjectError(str(error)) from None
        cost = (time.perf_counter() - began) / max(steps, 1)
        return followed(follow) | {"there": not more and follow.stopped is None, "cost": cost}

    def _begun(self, folder: Path, tag: str, support: str, whole: bool) -> Following:
        """Return the structure as drawn, with the ties that are there as the support moves."""
        from assessment.app.session import model_tag
        from assessment.project.model import build_model
        from assessment.project.project import survey_project
        from assessment.project.schema import ORIGINAL
        from mechanics import Following

        project = survey_project(folder)[0]
        if model_tag(project) != tag:
            raise ProjectError("the project has changed meanwhile; move the support again")
        if self.built is None or self.built[0] != tag:
            self.built = (tag, build_model(project))
            gc.unfreeze()
            gc.collect()
            gc.freeze()  # what is built stays: to look through it again and again takes as long as some answers
        own = next((each for each in project.settlements if each.support == support and not each.after), None)
        model = self.built[1].states[own.name if own else ORIGINAL].settling
        step = max(own.increment_m if own else 1e-3, 0.0 if whole else model.size / 50.0)
        return Following(model, support, sliding=project.contacts.sliding, increment=step)


def followed(follow: Following) -> dict[str, Any]:
    """Return where a support that is led has taken the structure, m, rad and kN.

    `positions` (b, 3): displacements of the blocks; `hinges` (h, 2): where a joint that has opened presses on its edge.
    """
    import numpy as np

    from assessment.app.pictures import bilingual
    from assessment.results.joint_states import EDGE, IDLE, shares
    from mechanics.model import end_gaps, end_points

    step, model = follow.equilibrium, follow.model
    at, contacts = step.state.positions, step.contacts
    places = contacts.places(at)
    share = np.nan_to_num(shares(places, step.forces), nan=0.5)
    open_ = end_gaps(places).max(axis=1) > OPEN * model.size
    loaded = (step.forces[:, 0] > IDLE * model.weight) & ~contacts.ties
    hinge = open_ & loaded & (abs(share - 0.5) > 0.5 - EDGE)
    ends = end_points(contacts, at)[hinge]
    hinges = ends[:, 0] + share[hinge, None] * (ends[:, 1] - ends[:, 0])
    return {
        "positions": (at - model.initial.positions).round(6).tolist(),
        "hinges": hinges.round(5).tolist(),
        "reaction": follow.reaction.round(6).tolist(),
        "at": follow.reached.tolist(),
        "fallen": follow.fallen,
        "stopped": None if follow.stopped is None else bilingual(follow.stopped),
    }
