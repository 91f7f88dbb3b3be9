"""A time history as a GIF: the blocks to true scale, in real time."""

from __future__ import annotations

import tempfile
from concurrent.futures import Future
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.patches import PathPatch

from assessment.report.figures.drawings.parts import moved_ends
from assessment.report.figures.motions import bounds_of_views, shaken
from assessment.report.figures.style import sheet
from assessment.report.text.language import slug, words_of
from assessment.results.configurations.faces import outlines
from assessment.results.schema import History, Results, known
from assessment.runtime.files import naming, write_atomically
from assessment.runtime.pool import Pool
from mechanics.pictures import GHOST, INK, STYLE, SUPPORT, TIE

DOTS_PER_INCH = 110


def write_animations(pool: Pool, folder: Path) -> list[Future[Path]]:
    """Begin to write `history_N_STATE.gif` into the folder for every history whose project asks for an animation."""
    results: Results = pool.held
    futures = []
    for index, motion in enumerate(results.motions or []):
        for state, entry in shaken(results, motion.name).items():
            if entry.frames:
                path = folder / f"history_{index + 1}_{slug(results, state)}.gif"
                futures.append(pool.apply(_write_animation, path, state, motion.name))
    return futures


def _write_animation(results: Results, path: Path, state: str, record: str) -> Path:
    with naming(path):  # the film is made elsewhere first
        write_atomically(path, animation(results, state, shaken(results, record)[state]))
    return path


def animation(results: Results, state: str, entry: History) -> bytes:
    """Draw the frames of a history over the state at rest, dashed; the same bytes for the same results."""
    words, shape = words_of(results), outlines(results)
    start = shape.moved(results.states[state].configuration)
    times = known(entry.frames).time_s
    configurations = known(entry.frames).configuration
    views = [shape.moved(configuration) for configuration in configurations]
    supports = np.array([block.support is not None for block in results.geometry.blocks])
    with mpl.rc_context(STYLE):  # type: ignore[arg-type]
        page = sheet(bounds_of_views(start, views), border_mm=5.0, height_mm=115.0, below_mm=5.0)
        (axes,) = page.panels
        axes.add_artist(PathPatch(start.path(range(len(supports))), **GHOST))
        groups = [
            (chosen, PathPatch(start.path(chosen), facecolor=grey, edgecolor=INK, linewidth=0.45))
            for chosen, grey in ((np.flatnonzero(~supports), "0.92"), (np.flatnonzero(supports), SUPPORT))
            if len(chosen)
        ]
        for _, patch in groups:
            axes.add_patch(patch)
        pulled = [axes.plot([], [], **TIE)[0] for _ in moved_ends(results, state, configurations[0])]

        def draw(frame: int) -> list[PathPatch]:
            for chosen, patch in groups:
                patch.set_path(views[frame].path(chosen))
            for line, ends in zip(pulled, moved_ends(results, state, configurations[frame]), strict=True):
                line.set_data(*ends.T)
            axes.set_title(
                words.plain("figure.frame", state=words.state(state), record=entry.record, time=times[frame])
            )
            return [patch for _, patch in groups]

        film = FuncAnimation(page.figure, draw, frames=len(views), blit=False)
        return _gif(film, times[1] - times[0])


def _gif(film: FuncAnimation, frame: float) -> bytes:
    """The bytes of an animation with frames of equal duration; matplotlib's writer wants a file of its own."""
    rate = 1.0 / (round(frame, 2) + 1e-6)  # GIF counts hundredths of a second, and the writer rounds down
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "film.gif"
        film.save(path, writer=PillowWriter(fps=rate), dpi=DOTS_PER_INCH)  # type: ignore[arg-type]
        return path.read_bytes()
