"""Scans: how often the time step is halved, and elastic joints without damping."""

from itertools import permutations
from types import SimpleNamespace

import pytest

from assessment.analyses.scan import Reach, Scan
from assessment.results.schema.dynamic import Level
from assessment.studies.scans import Asked, Scans
from assessment.studies.variants import Study
from tests.support.typed import made


@pytest.mark.parametrize(
    ("levels", "halvings"),
    [
        ([(0.58, 0.507, 0.507)], 1),
        ([(0.58, 0.54, 0.50)], 2),
        ([(0.5, 0.51, 0.5), (0.52, 0.49, 0.5)], 0),
        ([(0.55, 0.5, 0.5), (0.46, 0.5, 0.5)], 0),  # by chance this way and that
        ([(None, None, None)], 0),
        ([(0.55, 0.5, 0.5), (None, None, None)], 1),  # what never collapses says nothing
        ([(None, 0.5, 0.5)], 1),  # at the step given it stands up to the largest level
        ([(0.5,)], 0),
    ],
)
def test_the_time_step_is_halved_as_often_as_the_mean_of_the_levels_needs(levels, halvings):
    scans, asked = Scans(SimpleNamespace(accuracy="standard"), None), []
    for k, by_step in enumerate(levels):
        asked.append(Asked(SimpleNamespace(start=None, starts=True), 1, 1, Reach(5.0), None))
        asked[-1].__dict__["key"] = str(k)
        scans.found[str(k)] = {
            n: Scan([made(Level, {"pga_g": level or 0.9, "collapsed": level is not None})])
            for n, level in enumerate(by_step)
        }
    assert scans.needed(asked)[0] == halvings


@pytest.mark.parametrize(
    ("contacts", "damping", "told"), [("elastic", None, 1), ("elastic", 0.05, 0), ("rigid", None, 0)]
)
def test_elastic_joints_without_damping_are_warned_of(monkeypatch, contacts, damping, told):
    """Of an arch of nine blocks levels at 2.5 ms were 20 % above those at 0.1 ms, and of an explicit code."""
    monkeypatch.setattr(Scans, "run", lambda *arguments: None)
    table = SimpleNamespace(contacts=contacts, damping_ratio=damping, integrator="second-order")
    study = Study()
    asked = Asked(
        SimpleNamespace(start=None, starts=True, setting=SimpleNamespace(table=table)), 1, 1, Reach(5.0), None
    )
    asked.__dict__["key"] = ""
    Scans(SimpleNamespace(accuracy="fast"), None).settle("campaign", [asked], False, study)
    assert [
        str(note).startswith("campaign: elastic joints without damping_ratio") for note in study.warnings
    ] == [True] * told


@pytest.mark.parametrize("order", list(permutations(["stands", "falls", "falls too"])))
def test_the_time_step_is_judged_where_records_collapse(monkeypatch, order):
    """With a record that never collapses first, all had the step given: a block fell at 1.54 g, not at 1.07."""
    by_step = {"stands": (None, None, None), "falls": (1.65, 1.07, 1.07), "falls too": (1.9, 1.7, 1.7)}

    def run(self, stage, asked, halvings=0):
        for each in asked:
            level = by_step[each.key][halvings]
            point = made(Level, {"pga_g": level or 3.0, "collapsed": level is not None})
            self.found.setdefault(each.key, {})[halvings] = Scan([point])

    monkeypatch.setattr(Scans, "run", run)
    table = SimpleNamespace(contacts="rigid", damping_ratio=None, integrator=None)
    scans, asked = Scans(SimpleNamespace(accuracy="fast"), None), []
    for record in order:
        asked.append(
            Asked(
                SimpleNamespace(start=None, starts=True, setting=SimpleNamespace(table=table)),
                1,
                1,
                Reach(5.0),
                None,
            )
        )
        asked[-1].__dict__["key"] = record
    scans.settle("incremental", asked, True, Study())
    assert scans.counts == 1
