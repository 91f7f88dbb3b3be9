"""Campaigns: their records, a small one on the rocking block, what a thousand histories leave."""

import math
import tracemalloc
import weakref
from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest

from assessment.analyses import scan
from assessment.analyses.time_history import ENERGIES, Response
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.project.model import build_model
from assessment.project.motions import BaseMotion, check_record_set, doubtful_records
from assessment.project.project import load_project
from assessment.project.schema import CampaignTable
from assessment.results.schema import as_bytes
from assessment.results.schema.part import plain
from assessment.runtime import tasks
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.errors import ProjectError
from assessment.runtime.progress import Show
from assessment.studies import campaign
from assessment.studies.campaign import compatibility, scaled_to
from assessment.workflow.stages import run as workflow
from mechanics.records.record import Record
from tests.support.block_project import ASSESSMENT, PROJECT, edit, read_results, run, timeless, write_block
from tests.support.campaign_project import SEARCHES, write_campaign


@pytest.fixture
def block(tmp_path, no_figures):
    folder = write_campaign(tmp_path / "block", SEARCHES, 3)
    edit(folder, "scatter = 2\n", 'scatter = 2\naccuracy = "fast"\n')
    return folder


def test_a_small_campaign(block):
    assert run(block) == 0
    found = read_results(block / "output")["campaign"]
    rows = found["combinations"]
    assert [(row["record"], row["share"], row["sign"]) for row in rows] == [
        (f"wave{k}", share, 1) for share in (0.0, 1.0) for k in (1, 2, 3)
    ]
    for row in rows:
        safe, collapse, lowest = row["pga_safe_g"], row["pga_collapse_g"], row["lowest_collapse_g"]
        assert 0.0 < collapse - safe <= 0.05 * collapse and row["pga_collapse_range"][0] == collapse
        fallen = {point["pga_g"]: point["collapsed"] for point in row["points"]}
        assert fallen[lowest] and not fallen[safe] and row["runs"] == row["counts"]["motions"] == len(fallen)
    assert len({row["time_step_s"] for row in rows}) == 1, "finer steps that were only looked at do not count"
    original, settled = found["fragility"]
    assert original["median_g"] == pytest.approx(
        math.exp(np.mean([math.log(row["level_50_g"]) for row in rows[:3]]))
    )
    for fitted, own in ((original, rows[:3]), (settled, rows[3:])):
        apart = np.std(np.log([row["level_50_g"] for row in own]))
        within = math.sqrt(np.mean([(row["beta"] or 0.0) ** 2 for row in own]))
        numbers = [fitted[key] for key in ("beta", "beta_record", "beta_ensemble")]
        assert numbers == pytest.approx([math.hypot(apart, within), apart, within])
    assert settled["rule"] == "lowest"
    assert settled["pga_collapse_g"] == min(row["pga_collapse_g"] for row in rows[3:])
    at_rest, lost = found["loss"]
    assert at_rest["dynamic"] == at_rest["static"] == 0.0
    pairs = sorted(1.0 - b["level_50_g"] / a["level_50_g"] for a, b in zip(rows[:3], rows[3:], strict=True))
    assert lost["dynamic"] == pytest.approx(pairs[1]) and 0.0 < lost["static"] < 0.3
    _static_of_the_checks(read_results(block / "output"))
    assert (block / "output" / "tables" / "fragility.xml").is_file()


def _static_of_the_checks(results):
    """One static capacity a state: S a_g of its check; the shape of the spectrum and its S are kept, and cancel."""
    states, loss = results["states"].values(), results["campaign"]["loss"]
    checks = [state["capacity"]["+x"]["SLV"] for state in states]
    assert checks[0]["S"] == checks[1]["S"] == checks[0]["demand_S"] > 1.0
    assert [row["static_capacity"] for row in loss] == [check["pga_g"] for check in checks]
    assert loss[1]["static"] == pytest.approx(results["comparison"][0]["static_reduction"], rel=1e-12)


def test_a_scan_begins_where_its_neighbour_ends_and_levels_do_not_depend_on_what_is_finished(block):
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "scatter = 2", "scatter = 1")
    project = load_project(block)
    model = build_model(project)
    whole = workflow(project, model, jobs=2)
    shows = [Stopping(after) for after in (0, 2)]
    for show in shows:  # stopped, then run to its end, in one process
        with suppress(KeyboardInterrupt):
            again = workflow(project, model, jobs=1, store=Store(block / "kept"), show=show)
    assert [show.record.stages[-1].ended for show in shows] == [False, True], "stopped"
    assert again.complete and sum(show.finished for show in shows) == whole.computed
    assert timeless(plain(again.results)) == timeless(plain(whole.results))
    rows = plain(whole.results)["campaign"]["combinations"]
    # eight levels down to 0.7 of the lowest, two above, and what is passed on the way from the neighbour's
    assert all(row["runs"] <= 16 for row in rows[1:])


class Stopping(Show):
    """Interrupts a campaign of two combinations before so many are finished; counts all that is `finished`."""

    def __init__(self, after):
        super().__init__()
        self.left = after

    @property
    def finished(self):
        return sum(stage.done for stage in self.record.stages)

    def changed(self, stage, title=None):
        if (stage.name, stage.total) == ("campaign", 2) and stage.done > self.left:
            raise KeyboardInterrupt


def test_stripes_by_spectral_acceleration(block):
    stripes = 'method = "stripes"\nlevels_g = [0.2, 0.4, 1.2]\nmeasure = "Sa(T)"\nperiod_s = 0.5\n'
    edit(block, "tolerance = 0.2\n", stripes)
    assert run(block, "--only", "campaign") == 0
    results = read_results(block / "output")
    found = results["campaign"]
    for row in found["combinations"]:
        record = next(each for each in found["records"] if each["record"] == row["record"])
        ratio = record["sa_g"] / record["record_pga_g"]
        assert [point["pga_g"] * ratio for point in row["points"]] == pytest.approx([0.2, 0.4, 1.2])
        assert len(row["collapsed"]) == 3
    assert all(row["rule"] is None for row in found["fragility"])
    assert found["loss"][1]["static"] is not None  # the static check comes with it
    before, after = (each["median_g"] for each in found["fragility"])
    low, high = found["loss"][1]["dynamic_range"]
    assert found["loss"][1]["dynamic"] == pytest.approx(1.0 - after / before)
    assert low <= found["loss"][1]["dynamic"] <= high and found["loss"][1]["distinguishable"] == (
        not low <= 0.0 <= high
    )


def test_the_static_loss_beside_rigid_motions_is_that_of_rigid_joints(block):
    """On soft joints the block loses more: that is another structure's loss."""
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "tolerance = 0.2\n", 'method = "stripes"\nlevels_g = [0.1]\n')
    edit(block, "normal_stiffness_kN_m3 = 1e6", "normal_stiffness_kN_m3 = 2e4")
    losses = []
    for soft in (False, True):
        if soft:
            edit(block, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
            edit(block, 'model = "none"', 'model = "trilinear"')
        assert run(block, "--only", "campaign") == 0
        losses.append(read_results(block / "output")["campaign"]["loss"])
    rigid, beside = losses
    assert beside[1]["static"] == pytest.approx(rigid[1]["static"], rel=1e-12)
    assert beside[1]["static_capacity"] == pytest.approx(rigid[1]["static_capacity"], rel=1e-12)


def test_both_signs_of_a_structure_that_is_its_own_mirror_image_are_one_run(block):
    """As drawn; the block whose base has turned is none. What is not run is what it would have been."""
    edit(block, "point_m = [0.3, 2.4]", "point_m = [0.0, 2.4]")
    edit(block, "scatter = 2", "scatter = 1")
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "tolerance = 0.2\n", 'method = "stripes"\nlevels_g = [0.2, 0.4]\n')
    edit(block, "signs = [1]", "signs = [1, -1]")
    assert run(block, "--only", "campaign") == 0
    found = read_results(block / "output")["campaign"]
    one, image, settled, other = found["combinations"]
    same = {"settlement": "base turned", "share": 0.0, "sign": 1}
    assert found["computed"] == 3 and image["same_as"] == same
    assert image["collapsed"] == one["collapsed"] and not {"same_as"} & {*settled, *other}
    assert settled["points"] != other["points"]
    edit(block, "signs = [1, -1]", "signs = [-1]")
    edit(block, "shares = [0.0, 1.0]", "shares = [0.0]")
    assert run(block, "--only", "campaign") == 0
    [alone] = read_results(block / "output")["campaign"]["combinations"]
    own, mirrored = ([point["peak_displacement_m"] or 0.0 for point in row["points"]] for row in (alone, one))
    assert own == pytest.approx(mirrored, rel=1e-6) and alone["collapsed"] == one["collapsed"]


def made_record(spectrum, seed) -> Record:
    """A record in the place of one made to the spectrum, which takes seconds: as strong."""
    a = np.random.default_rng(seed).normal(size=600) * np.hanning(600)
    return Record(spectrum.ag * a / abs(a).max(), 0.01, f"generated {seed}")


def test_records_are_made_to_the_spectrum_of_the_site(block, monkeypatch):
    monkeypatch.setattr(campaign, "made_record", made_record)
    edit(block, 'records = ["wave*.csv"]', 'records = "generate:3"')
    edit(block, "tolerance = 0.2", 'method = "stripes"\nlevels_g = [0.01]\nspectrum_compatible = true')
    assert run(block, "--only", "campaign", "--jobs", "1") == 0
    found = read_results(block / "output")["campaign"]
    assert [each["record"] for each in found["records"]] == ["generated 1", "generated 2", "generated 3"]
    spectrum = found["spectrum"]
    deviation = np.array(spectrum["mean_g"]) / np.array(spectrum["target_g"]) - 1.0
    assert spectrum["limit_state"] == "SLV"  # the farthest of the project
    assert spectrum["lowest_deviation"] == pytest.approx(deviation.min())
    assert not any(row["collapsed"][0] for row in found["combinations"])
    assert all(row["median_g"] is None for row in found["fragility"])  # nothing fell


@pytest.mark.parametrize(("factor", "within"), [(0.89, False), (0.91, True), (1.29, True), (1.31, False)])
def test_a_mean_spectrum_is_that_of_the_site_from_a_tenth_below_to_three_tenths_above(
    monkeypatch, factor, within
):
    target = ElasticSpectrum(0.25, 2.4, 0.3)
    monkeypatch.setattr(campaign, "spectrum_of", lambda _, periods: factor * target.acceleration(periods))
    found = campaign.compatibility("SLV", target, [None], SimpleNamespace(periods_s=(0.15, 2.0)))
    assert found.lowest_deviation == pytest.approx(factor - 1.0) == found.highest_deviation
    assert found.within is within


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('records = ["wave*.csv"]', 'records = "generate:0"', 'campaign.records: "generate:0" is no number'),
        (
            'records = ["wave*.csv"]',
            'records = "generate:7"\ntime_step_s = 0.02',
            "campaign.time_step_s: records are made at 0.01 s",
        ),
        (
            'records = ["wave*.csv"]',
            'records = "generate:7"\nvertical_records = ["wave1.csv"]',
            "campaign.vertical_records: generated records have none",
        ),
        ("signs = [1]", 'settlements = ["base turnt"]', 'did you mean "base turned"'),
        ("signs = [1]", 'measure = "Sa(T)"', "campaign.period_s: missing"),
        ("signs = [1]", 'method = "stripes"', "campaign.levels_g: missing"),
        ("signs = [1]", "scale_limits = [2.0, 0.5]", "campaign.scale_limits: [2, 0.5] is no range; write"),
        ("shares = [0.0, 1.0]", "shares = [0.0, 1e-6, 1.0]", "campaign.shares[2]: 1e-06 of the movement moves"),
        ("shares = [0.0, 1.0]", "shares = [1.0, 0.0]", "campaign.shares: not in order"),
        ("signs = [1]", "curve_members = [1, 3]", "campaign.curve_members[2]: 3: scatter = 2 runs no such member"),
    ],
)  # fmt: skip
def test_wrong_input_is_refused_by_key(block, capsys, old, new, text):
    edit(block, old, new)
    assert run(block) == 2
    assert text in capsys.readouterr().err


def motion(name, acceleration, step=0.01):
    record = Record(np.asarray(acceleration), step, name)
    return BaseMotion(record, record, record.pga, 1.0)


def noise(seed, peak=0.3, count=1000):
    a = np.random.default_rng(seed).standard_normal(count) * np.sin(np.linspace(0.0, math.pi, count)) ** 2
    return peak * a / abs(a).max()


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
        ("a mean of 0.048 g", motion("a", noise(1) + 0.05)),
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


RECORDS, SAMPLES = 10, 2000
TABLE = """[campaign]
records = ["made*.csv"]
shares = [0.0, 0.25, 0.5, 0.75, 1.0]
contacts = "rigid"
tolerance = 0.05
"""
MEGABYTE = 1e6


@pytest.fixture
def project(tmp_path):
    folder = write_block(tmp_path / "block", "scatter = 5\n" + PROJECT + TABLE + ASSESSMENT)
    random, time = np.random.default_rng(1), 0.01 * np.arange(SAMPLES)
    for number in range(RECORDS):
        noise = 0.3 * np.sin(math.pi * time / time[-1]) * random.uniform(-1.0, 1.0, SAMPLES)
        np.savetxt(folder / f"made{number:02}.csv", np.column_stack([time, noise]), "%.6f", ",")
    return load_project(folder)


class MadeUp:
    """In the place of `respond`: collapses above a level that the record and the state tell, as large as a real one."""

    def __init__(self):
        self.count, self.most, self.alive = 0, 0, weakref.WeakSet()

    def __call__(self, shaking, factor, **__):
        model, motion, start = shaking.model, shaking.motion, shaking.start
        own = int(motion.name[4:])
        tilt = abs(start.positions[:, 2]).max()
        record = motion.record
        sign = np.sign(record.acceleration[round(0.07 / record.time_step)])  # the same at any time step
        capacity = (0.4 - 5.0 * tilt) * math.exp(0.3 * math.sin(own + sign))
        strength = factor * motion.pga / capacity
        found = Response(
            0.01 * np.arange(SAMPLES),
            strength**8 * np.sin(np.arange(SAMPLES) * (1.0 + 10.0 * strength)),  # as what rocks, near collapse alone
            np.ones((SAMPLES, len(model.blocks), 3)),
            np.ones((SAMPLES, len(model.contacts), 3)),
            (
                SimpleNamespace(
                    collapsed=strength > 1.0, collapse_reason="it fell", worst=1e-12, notes=(), steps=SAMPLES,
                    skipped=0, lifting=0, programs=SAMPLES, iterations=SAMPLES, halvings=0,
                    model=model,
                    energy=SimpleNamespace(**dict.fromkeys((*ENERGIES, "dissipated"), np.zeros(2))),
                ),
            ),
        )  # fmt: skip
        self.count += 1
        if not tracemalloc.is_tracing():
            tracemalloc.start()
        self.alive.add(found)
        self.most = max(self.most, len(self.alive))
        return found


def test_of_a_thousand_histories_numbers_are_left_and_no_curves(project, tmp_path, monkeypatch):
    """One column of their curves alone would be 20 MB. Measured: results of 0.66 MB."""
    made, store = MadeUp(), Store(tmp_path / FOLDER)
    monkeypatch.setattr(scan, "respond", made)
    monkeypatch.setattr(tasks, "processes", lambda _: 0)  # all in this process
    try:
        outcome = workflow(project, build_model(project), jobs=1, store=store)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    campaign = plain(outcome.results)["campaign"]
    counted = sum(row["runs"] for row in campaign["combinations"])
    # three scans are run with half the step too
    assert 1_200 <= counted <= made.count <= 1.05 * counted
    assert len(campaign["combinations"]) == campaign["computed"] == 10 * RECORDS
    assert all(row["pga_collapse_g"] for row in campaign["combinations"])
    assert made.most == 1  # whole motion at a time
    assert peak < 30 * MEGABYTE
    assert len(as_bytes(outcome.results)) < 0.8 * MEGABYTE
    assert sum(entry.stat().st_size for entry in store.folder.iterdir()) < 0.8 * MEGABYTE
