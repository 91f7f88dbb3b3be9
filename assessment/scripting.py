"""What scripts call beside `mechanics`: the structures of the templates, incremental analysis, fragility."""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from assessment.analyses.fragility import Dispersion, RecordLevel, over_records
from assessment.analyses.histories import Scatter
from assessment.analyses.scan import Reach, scan
from assessment.analyses.time_history import Setting, Shaking
from assessment.project.catalogue.new_project import TEMPLATES, new_project, template_options
from assessment.project.model import build_model
from assessment.project.motions import BaseMotion
from assessment.project.project import load_project
from assessment.project.schema import ControlTable, MotionTable
from mechanics import ArgumentError, Assembly, ConvergenceError, Material, Record, State
from mechanics.pictures import draw_curve
from mechanics.types import Array, Mask

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

KEYWORD = inspect.Parameter.KEYWORD_ONLY
AGREE = 0.05  # of two motions of an ensemble, relative: they are the same


@cache
def _builder(template: str) -> Callable[..., Assembly]:

    def build(
        *, material: Material | None = None, depth_m: float | None = None, **dimensions: float
    ) -> Assembly:
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / template
            new_project(folder, template, dimensions)
            model = build_model(load_project(folder)).states["original"].assembly
            return replace(
                model,
                blocks=[
                    replace(block, material=material or block.material, depth=depth_m or block.depth)
                    for block in model.blocks
                ],
            )

    options, name = template_options(template), template.replace("-", "_")
    first = (TEMPLATES[template].__doc__ or "").splitlines()[0]
    told = [f"    {key}: {it.description}, {it.unit}, by default {it.default}" for key, it in options.items()]
    build.__doc__ = "\n".join([
        first.replace("Return", "Return the structure of the template:"), "", *told,
        "    material, depth_m: of all blocks, instead of the template's", "",
        "Raises ProjectError, a ValueError, for a dimension that does not fit.",
    ])  # fmt: skip
    build.__module__, build.__name__, build.__qualname__ = "assessment", name, name
    defaults = {key: each.default for key, each in options.items()} | {"material": None, "depth_m": None}
    keys = [inspect.Parameter(key, KEYWORD, default=default) for key, default in defaults.items()]
    build.__signature__ = inspect.Signature(keys)  # type: ignore[attr-defined]
    return build


def __getattr__(name: str) -> Callable[..., Assembly]:
    """Return the function that makes the structure of a template of that name."""
    if (template := name.replace("_", "-")) in TEMPLATES:
        return _builder(template)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@dataclass(frozen=True, eq=False, repr=False)
class IncrementalCurve:
    """The levels (k,), PGA in g, at which a record was run, in their order.

    `peaks` (k,) m: largest displacement of the control point, NaN where the structure `collapsed` (k,).
    """

    record: str
    levels: Array
    peaks: Array
    collapsed: Mask

    @property
    def collapse(self) -> float | None:
        """The lowest of the `levels` (g) at which the structure collapses; None: at none.

        Collapse comes in bands: a narrow one below, between two levels, is missed (seen: 0.57 g below 0.73 g).
        """
        return float(self.levels[self.collapsed].min()) if self.collapsed.any() else None

    @property
    def safe(self) -> float:
        """The highest level (g) that was withstood below the collapse."""
        below = self.levels[~self.collapsed & (self.levels < (self.collapse or np.inf))]
        return float(below.max(initial=0.0))

    def __repr__(self) -> str:
        fell = "no collapse" if self.collapse is None else f"collapse at {self.collapse:.4g} g"
        return (
            f"IncrementalCurve({self.record}, {len(self.levels)} levels, {fell}, safe at {self.safe:.4g} g)"
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the peaks of the levels that were withstood; return the matplotlib axes."""
        labels = ("peak displacement of the control point [mm]", "PGA [g]")
        stood = ~self.collapsed
        return draw_curve(1000.0 * self.peaks[stood], self.levels[stood], {}, labels, self.record, axes)

    def to_frame(self) -> pd.DataFrame:
        """Return the levels as a table."""
        import pandas as pd  # late: only tables need it

        found = {"pga_g": self.levels, "peak_displacement_m": self.peaks, "collapsed": self.collapsed}
        return pd.DataFrame(found)


def incremental(
    model: Assembly,
    record: Record,
    control: ArrayLike,
    state: State | None = None,
    contacts: Literal["rigid", "elastic"] = "rigid",
    tolerance_g: float = 0.01,
    max_scale: float = 5.0,
) -> IncrementalCurve:
    """Scale a record until the structure collapses, as [incremental] of a project does.

    `control`: a drawn point (2,) m in or on a block; `state`: at rest, where every motion begins, default as drawn;
    `tolerance_g`: between the lowest collapse and the highest level withstood below it. Raises ConvergenceError where a
    motion is not solved, ArgumentError as `time_history`, and for a record that is none.
    """
    if not isinstance(record, Record):
        raise ArgumentError(f"record = {type(record).__name__}: must be a Record, as read_record returns")
    x, z = (float(value) for value in np.asarray(control))
    setting = Setting(MotionTable(contacts=contacts), ControlTable(name="control", point_m=(x, z)))
    reach = Reach(max_scale, width=tolerance_g)
    shaken = BaseMotion(record, record, record.pga, 1.0)
    found = scan(Shaking(model, shaken, setting, model.starting(state)), Scatter(1, AGREE), reach)
    if found.reason is not None:
        raise ConvergenceError(found.reason)
    # of a collapse there is no peak, NaN
    peaks = np.array([each.peak_displacement_m for each in found.points], dtype=float)
    fallen = np.array([each.collapsed for each in found.points])
    return IncrementalCurve(record.name, np.array([each.pga_g for each in found.points]), peaks, fallen)


def fragility(curves: Iterable[IncrementalCurve]) -> Dispersion | None:
    """Return median and β of the PGA at collapse over records, by maximum likelihood; None where none collapses.

    A record that is withstood at all of its levels counts as one that collapses above the highest.
    """
    return over_records(
        [RecordLevel(each.record, each.collapse or each.safe, each.collapse is None, 0.0) for each in curves]
    )
