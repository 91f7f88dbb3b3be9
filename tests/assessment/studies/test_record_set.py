"""The records of a campaign: what is refused and doubted, scaling to a spectrum, measures of intensity."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from assessment.analyses.fragility import RecordLevel
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.project.motions import BaseMotion, check_record_set, doubtful_records
from assessment.project.schema import CampaignTable
from assessment.runtime.errors import ProjectError
from assessment.studies.campaign import compatibility, scaled_to
from assessment.studies.searches import Measures
from mechanics.records.record import Record


def motion(name, acceleration, step=0.01):
    record = Record(np.asarray(acceleration), step, name)
    return BaseMotion(record, record, record.pga, 1.0)


def noise(seed, peak=0.3, count=1000):
    a = np.random.default_rng(seed).standard_normal(count) * np.sin(np.linspace(0.0, math.pi, count)) ** 2
    return peak * a / abs(a).max()


def test_the_measure_that_collapse_follows_has_the_least_dispersion():
    """Sines of 0.25 to 1 s that collapse at one peak velocity: β of PGV is none, that of PGA is not."""
    motions, levels = [], []
    for period in (0.25, 0.5, 1.0):
        time = 0.005 * np.arange(1001)
        motions.append(motion(f"{period}", 0.3 * np.sin(2.0 * np.pi * time / period), 0.005))
        levels.append(RecordLevel(f"{period}", 0.2 / period, False, 0.0))
    measures = Measures.of(SimpleNamespace(campaign=None), motions)
    found = {each.measure: each for each in measures.fits(levels)}
    assert found["PGV"].beta < 0.02 < 0.5 < found["PGA"].beta
    assert found["PGV"].median == pytest.approx(2.0 * 0.2 * 9.80665 / (2.0 * math.pi), rel=0.02)
    assert found["Sa(T)"].period_s == 1.0


@pytest.mark.parametrize("key", ["incremental", "campaign"])
def test_a_set_with_one_motion_twice_is_refused_scaled_and_turned_too(key):
    project, other = SimpleNamespace(source="project.toml"), motion("b", noise(2))
    with pytest.raises(ProjectError, match="same motion"):
        check_record_set(project, key, [motion("a", noise(1)), other, motion("c", -0.5 * noise(1))])
    with pytest.raises(ProjectError, match=rf'{key}\.records: two records are called "a"'):
        check_record_set(project, key, [motion("a", noise(1)), motion("a", noise(2))])
    check_record_set(project, key, [motion("a", noise(1)), other])


def test_doubtful_records_are_warned_of():
    assert doubtful_records([motion("a", noise(1))]) == []
    for text, doubtful in (
        ("unit", motion("a", noise(1, 3.0))),
        ("lasts", motion("a", noise(1, count=300))),
        ("begins or ends", motion("a", noise(1)[450:960])),
    ):
        [said] = doubtful_records([doubtful])
        assert text in said and said.startswith("campaign, a: ")


def test_records_are_scaled_to_the_spectrum_within_limits():
    target = ElasticSpectrum(0.3, 2.4, 0.36, "B", "T1", 0.05)
    table = CampaignTable(records=("r",), spectrum_compatible=True, scale_limits=(0.5, 20.0))
    one = scaled_to(target, [motion("a", noise(1))], table)
    weak, strong = scaled_to(target, [motion("a", 0.8 * noise(1)), motion("b", 1e-3 * noise(1))], table)
    assert weak.pga == pytest.approx(one[0].pga) and weak.notes == ()
    assert strong.scale == 20.0 and "scale_limits = [0.5, 20]" in strong.notes[0]
    found = compatibility("SLC", target, one, table)
    assert found.lowest_deviation < 0.0 < found.highest_deviation
