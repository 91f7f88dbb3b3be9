"""The identification of a project: every hypothesis searched and fitted, compared with the others, and told."""

import math
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import reduce

import numpy as np
from scipy.special import gammaincc

from assessment.analyses.found import as_part
from assessment.analyses.paths import quality_row
from assessment.project.model import Gauge, gauges, readings
from assessment.project.project import Project
from assessment.project.schema import MeasurementTable
from assessment.results.schema import Configuration, QualityRow
from assessment.results.schema import studies as parts
from assessment.results.summary import UNLIKELY
from assessment.runtime.progress import Show, Stage
from assessment.runtime.tasks import Workers
from assessment.studies import fit as fitting
from assessment.studies.variants import Study
from mechanics import Assembly, CollapseError, ConvergenceError, NoEquilibriumError
from mechanics.messages import Message, headed, message
from mechanics.procedures import Pushdown, SupportMovement, drawn_extent, pushdown_together, whole_movement
from mechanics.steps import Sliding
from mechanics.types import Array, Mask

IN_IT = 0.3  # of a unit vector: a component that takes part in a movement that is not determined


def open_movements(unknowns: fitting.Unknowns, directions: Array) -> list[Message]:
    """Return in words the movements, unit vectors (d, n) at right angles, that are not determined."""
    free = np.linalg.norm(directions, axis=0) > np.sqrt(1.0 - IN_IT**2)
    found = [_component(*unknowns.components[k]) for k in np.flatnonzero(free)]
    for direction in np.linalg.svd(np.where(free, 0.0, directions))[2][: len(directions) - len(found)]:
        pairs = zip(unknowns.components, direction, strict=True)
        names = [_component(*each) for each, part in pairs if abs(part) > IN_IT]
        found.append(reduce(lambda a, b: message("{first} together with {second}", first=a, second=b), names))
    return found


def kinked_components(unknowns: fitting.Unknowns, kinked: Mask) -> list[Message]:
    """Return the components (n, 2) whose prediction has a kink within a standard error, below or above, in words."""
    found = []
    for each, (below, above) in zip(unknowns.components, kinked.tolist(), strict=True):
        component = _component(*each)
        if below and above:
            found.append(message("{component}, on both sides", component=component))
        elif below:
            found.append(message("{component}, towards lower values", component=component))
        elif above:
            found.append(message("{component}, towards higher values", component=component))
    return found


def _component(support: str, name: str) -> Message:
    if name == "x":
        return message("the movement along x of the support {name}", name=support)
    if name == "z":
        return message("the movement along z of the support {name}", name=support)
    return message("the rotation of the support {name}", name=support)


def findings(found: parts.Identification) -> Iterator[Message]:
    """Yield what is not determined, what contradicts, and which hypotheses are not told from each other."""
    for each in found.hypotheses:
        title = message("identification, {hypothesis}", hypothesis=each.hypothesis)
        yield from (headed(title, text) for text in _of_hypothesis(each))
    best = None if found.best is None else found.hypotheses[found.best]
    for each in found.hypotheses:
        if best is not None and each is not best and not each.distinguished:
            yield message(
                "identification: the measurements do not tell one hypothesis ({first}) from another ({second}): their "
                "AIC differ by less than 2", first=best.hypothesis, second=each.hypothesis,
            )  # fmt: skip


def _of_hypothesis(each: parts.Explanation) -> Iterator[Message]:
    """Yield what is to be known of a hypothesis; of one that another explains far better, no more than that."""
    if each.chi_squared is None:
        yield message("no movement could be followed")
        return
    if each.probability is not None and each.probability < UNLIKELY:
        yield message(
            "the movement does not explain the measurements: a χ² of {square:.3g} or more has a probability of "
            "{probability:.2g}", square=each.chi_squared, probability=each.probability,
        )  # fmt: skip
        if len(each.movement) > 1:
            yield message("its supports move together, in proportion; by turns they may leave other cracks")
    if each.distinguished:
        return
    if each.degrees_of_freedom == 0:
        yield message(
            "as many unknowns as measurements: nothing is left by which the fit could be judged; measure more"
        )
    for text in each.undetermined:
        yield message("the measurements do not determine {text}; measure where it shows", text=text)
    for text in each.kinked:
        yield message(
            "the prediction has a kink within a standard error of {component}: hinges move to other joints there, and "
            "the standard error is the largest by the slopes on both sides", component=text,
        )  # fmt: skip
    for row in each.fit:
        if row.measurement in each.contradicting:
            yield message(
                "the measurement {name} contradicts the rest: predicted {predicted:.3g} {unit}, measured "
                "{measured:.3g} ± {sigma:.3g} {unit}", name=row.measurement, predicted=row.predicted,
                measured=row.measured, sigma=row.sigma, unit=row.unit,
            )  # fmt: skip
    if each.at_collapse:
        yield message("the fit would improve beyond what the structure survives")


ROUNDING = 1e-8  # of a block's size: a movement that is none
FARTHEST = 10.0  # of the largest measured displacement: the length of the paths of the search
COARSE = 50  # increments of a path of the search
FINE = 20  # increments of a movement that is refined
STARTS = 3  # directions that are refined


@dataclass
class Followed:
    """A path of moving supports: at each `share` (k,) of the whole movement the readings `shown` (k, m), mm or mrad."""

    share: Array
    shown: Array
    configuration: Configuration | None = None  # (b, 3) after the whole; None: not followed to there
    stopped: Message | None = None  # why no farther; None: it falls, or the whole was followed
    quality: list[QualityRow] = field(default_factory=list)
    seconds: float = 0.0


def follow(
    model: Assembly, movements: Sequence[SupportMovement], increments: int, sliding: Sliding, gauges: Sequence[Gauge]
) -> Followed:  # fmt: skip
    """Move the supports from their places as drawn, in so many increments, as far as they can be followed."""
    began = time.perf_counter()
    size = model.size
    sizes = (max(*map(abs, each.displacement), abs(each.rotation) * size) for each in movements)
    moved = tuple(each for each, far in zip(movements, sizes, strict=True) if far > ROUNDING * size)
    if not moved:
        start = model.initial
        shown = readings(model, gauges, start.positions)
        return Followed(np.zeros(1), shown[None, :], configuration=model.displaced(start).tolist())
    whole = max(whole_movement(model, each.support, each.displacement, each.rotation) for each in moved)
    reached, path, stopped = False, None, None
    try:
        path = pushdown_together(model, moved, whole / increments, sliding)
        reached = True
    except (NoEquilibriumError, ConvergenceError) as error:
        path = error.path if isinstance(error.path, Pushdown) else None
        stopped = None if isinstance(error, CollapseError) else error.message
    found = Followed(np.zeros(0), np.zeros((0, len(gauges))), stopped=stopped)
    if path is not None:
        states = [*path.states[:-1], path.final if reached else path.states[-1]]
        found.share = path.movement / whole
        found.shown = np.array([readings(model, gauges, state.positions) for state in states])
        found.configuration = model.displaced(path.final).tolist() if reached else None
        found.quality.append(quality_row("", "identification", path))
    found.seconds = time.perf_counter() - began
    return found


@dataclass(frozen=True, eq=False)
class MovementSearch:
    """How movements are followed: model, law of sliding, gauges, what was measured, processes; messages to `study`."""

    model: Assembly
    sliding: Sliding
    gauges: tuple[Gauge, ...]
    value: Array  # (m,) measured at the gauges, mm or mrad
    sigma: Array
    largest: float  # m, of the displacements
    workers: Workers
    study: Study
    # why paths of a hypothesis could not be followed to their end, other than by a collapse
    stopped: dict[fitting.Unknowns, list[Message]] = field(default_factory=lambda: defaultdict(list))

    def residual(self, shown: Array) -> Array:
        """Return the residuals over σ of readings (…, m)."""
        return (shown - self.value) / self.sigma

    def best(self, unknowns: fitting.Unknowns) -> fitting.Fit | None:
        """Return the best fit of a hypothesis; None where no movement could be followed."""
        directions = unknowns.directions()
        length = FARTHEST * self.largest
        paths = self.followed(unknowns, [length * each for each in directions], COARSE, "search")
        starts: list[tuple[float, Array]] = []
        for direction, path in zip(directions, paths, strict=True):
            if len(path.share):
                share, square = fitting.best_length(path.share, self.residual(path.shown))
                starts.append((square, share * length * direction))
        starts.sort(key=lambda each: each[0])
        fits, predict = [], self.predict(unknowns)
        for _, start in starts[:STARTS]:
            [residual] = predict([start])
            if residual is not None:
                fits.append(fitting.refined(unknowns, start, residual, predict, self.largest))
        return min(fits, key=lambda fit: fit.chi_squared, default=None)

    def predict(self, unknowns: fitting.Unknowns) -> fitting.Predict:
        """Return what predicts the residuals at values of the unknowns."""

        def residuals(values: Sequence[Array]) -> list[Array | None]:
            paths = self.followed(unknowns, values, FINE, "fit")
            return [None if path.configuration is None else self.residual(path.shown[-1]) for path in paths]

        return residuals

    def followed(
        self, unknowns: fitting.Unknowns, values: Sequence[Array], increments: int, what: str
    ) -> list[Followed]:
        """Return the path to each of the values (n,), m, of the unknowns; what they leave goes to the study."""
        tasks = [(self.model, unknowns.movements(u), increments, self.sliding, self.gauges) for u in values]
        titles = [f"{unknowns.title}, path {number}" for number in range(1, len(tasks) + 1)]
        found = self.workers.each(f"identification: {what}", follow, tasks, titles)
        for path in found:
            self.study.quality += path.quality
            self.study.seconds += path.seconds
            if path.stopped is not None:
                self.stopped[unknowns].append(path.stopped)
        return found


# difference of AIC up to which hypotheses are not told from each other (Burnham and Anderson, 2002)
AS_GOOD = 2.0
CONTRADICTS = 3.0  # σ between what is measured and predicted
DIGITS_M, DIGITS_RAD = 6, 7  # of a movement in a project file


def identification(project: Project, model: Assembly, workers: Workers, study: Study) -> parts.Identification:
    """Return the best movement of each hypothesis, compared; ProjectError for a point at no joint or in no block."""
    assert project.identification is not None
    found = gauges(project, model)
    lever = 0.5 * float(np.ptp(drawn_extent(model), axis=0).max())
    value, sigma = np.array([(each.value, each.sigma) for each in project.measurement]).T
    size = np.array([lever if each.kind == "lean" else 1.0 for each in project.measurement])
    largest = 1e-3 * float((size * np.maximum(abs(value), sigma)).max())
    law = project.contacts.sliding
    search = MovementSearch(model, law, tuple(found), value, sigma, largest, workers, study)
    table = project.identification
    asked = []
    for free in table.hypotheses:  # the components of each support
        components = ((at, name) for at, own in free.items() for name in fitting.COMPONENTS if name in own)
        asked.append(fitting.Unknowns(tuple(components), lever, table.downward_only))
    show, workers.show = workers.show, Show()  # one line of progress for all of their many short paths
    show.begin(stage := Stage("identification", len(asked), 0, float(len(asked))))
    hypotheses: list[parts.Explanation] = []
    try:
        for unknowns in asked:
            show.changed(stage, unknowns.title)
            hypotheses.append(_explained(project, search, unknowns))
            stage.reach(float(len(hypotheses)), 1)
    finally:
        workers.show = show
    show.end(stage)
    known = [each.aic for each in hypotheses if each.aic is not None]
    least = min(known, default=math.nan)
    alike = [each.aic is not None and math.isclose(each.aic, least, abs_tol=1e-6) for each in hypotheses]
    best = alike.index(True) if known else None  # of those that explain alike the first
    if best is not None:
        far = [each.aic is None or each.aic > least + AS_GOOD for each in hypotheses]
        hypotheses = [each.replace(distinguished=x) for each, x in zip(hypotheses, far, strict=True)]
    result = parts.Identification(
        hypotheses=hypotheses,
        best=best,
        sites=[_site(each, gauge) for each, gauge in zip(project.measurement, found, strict=True)],
        settlements=[] if best is None else _ready(hypotheses[best]),
    )
    study.findings += findings(result)
    for each in asked:
        if reasons := search.stopped[each]:
            text = message(
                "{count} movements that were tried could not be followed to their end, for another reason than a "
                "collapse; a better fit may lie there; the first: {reason}", count=len(reasons), reason=reasons[0],
            )  # fmt: skip
            title = message("identification, {hypothesis}", hypothesis=each.title)
            study.findings.append(headed(title, text))
    if best is None:
        study.failures.append(message("identification: no movement of any hypothesis could be followed"))
    return result


def _explained(project: Project, search: MovementSearch, unknowns: fitting.Unknowns) -> parts.Explanation:
    fit, n = search.best(unknowns), len(unknowns)
    freedom = len(project.measurement) - n
    if fit is None:
        return parts.Explanation(
            hypothesis=unknowns.title, unknowns=n, movement=[], chi_squared=None, degrees_of_freedom=freedom,
            probability=None, aic=None, distinguished=True, undetermined=[], kinked=[], contradicting=[],
            at_collapse=False, fit=[], configuration=None,
        )  # fmt: skip
    kinked, around = fitting.over_kinks(
        unknowns, fit, fitting.sureness(fit, search.largest).error, search.predict(unknowns)
    )
    sure = fitting.sureness(around, search.largest)
    [best] = search.followed(unknowns, [fit.u], FINE, "best movement")
    rows = []
    for each, off in zip(project.measurement, fit.residual.tolist(), strict=True):
        rows.append(as_part(
            parts.Fitted, each, measurement=each.name, measured=each.value, predicted=each.value + off * each.sigma,
            residual=off * each.sigma, residual_in_sigma=off,
        ))  # fmt: skip
    return parts.Explanation(
        hypothesis=unknowns.title, unknowns=n, movement=_movement(unknowns, fit, sure.error),
        probability=probability(fit.chi_squared, freedom) if freedom else None, chi_squared=fit.chi_squared,
        degrees_of_freedom=freedom, aic=fit.chi_squared + 2.0 * n, distinguished=False,
        undetermined=[*open_movements(unknowns, sure.open)], kinked=[*kinked_components(unknowns, kinked)],
        at_collapse=fit.stopped, fit=rows, configuration=best.configuration,
        contradicting=[row.measurement for row in rows if abs(row.residual_in_sigma) > CONTRADICTS],
    )  # fmt: skip


def probability(chi_squared: float, freedom: int) -> float:
    """Return the probability of a χ² as large with so many degrees of freedom: Q(ν/2, χ²/2)."""
    return float(gammaincc(0.5 * freedom, 0.5 * chi_squared))


def _movement(unknowns: fitting.Unknowns, fit: fitting.Fit, error: Array) -> list[parts.FittedMovement]:
    """Return the movement of each support with its standard errors."""
    errors = [float(each) if np.isfinite(each) else None for each in error / unknowns.size]
    keys = {"x": "x_standard_error_m", "z": "z_standard_error_m", "rotation": "rotation_standard_error_rad"}
    found = []
    for each in unknowns.movements(fit.u):
        pairs = zip(unknowns.components, errors, strict=True)
        own = {keys[name]: error for (support, name), error in pairs if support == each.support}
        x, z, turn = *each.displacement, each.rotation
        found.append(parts.FittedMovement(support=each.support, x_m=x, z_m=z, rotation_rad=turn, **own))
    return found


def _site(each: MeasurementTable, gauge: Gauge) -> parts.MeasuredPoint:
    found = parts.MeasuredPoint(measurement=each.name, point_m=list(each.point_m), block=gauge.block)
    if each.kind != "relative":
        return found
    origin = None if gauge.origin is None else list(gauge.origin)
    return found.replace(from_m=origin, from_block=gauge.origin_block)


def _ready(best: parts.Explanation) -> list[parts.ReadySettlement]:
    """Return the movement as the project file has it; of several supports at once there is none."""
    moving = [each for each in best.movement if each.x_m or each.z_m or each.rotation_rad]
    return [
        parts.ReadySettlement(
            name=f"{each.support}, as measured",
            support=each.support,
            displacement_m=[round(each.x_m, DIGITS_M), round(each.z_m, DIGITS_M)],
            rotation_rad=round(each.rotation_rad, DIGITS_RAD),
        )
        for each in moving
        if len(moving) == 1
    ]
