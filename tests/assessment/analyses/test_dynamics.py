"""The dynamic stages of a project, on the template's rocking block."""

from dataclasses import replace
from shutil import copy

import numpy as np
import pytest

from assessment.analyses import time_history as response
from assessment.analyses.time_history import TAIL as FREE
from assessment.analyses.time_history import Setting, Shaking, respond, sustained_peak, thinned
from assessment.ntc.spectrum import ElasticSpectrum, RecordSpectrum
from assessment.project.catalogue.new_project import RECORD, examples, new_project
from assessment.project.motions import BaseMotion, history_motions, set_motions
from assessment.project.project import load_project
from assessment.project.schema import ControlTable, HistoryTable
from assessment.report.document import tables
from assessment.results.schema.part import plain
from assessment.runtime.errors import ProjectError
from assessment.workflow.checking import read_motions
from mechanics import ConvergenceError
from mechanics.messages import message
from mechanics.records.record import Record, read_record, response_spectrum
from tests.support.block_project import TURNED, block, edit, outcome_of, write_block
from tests.support.structures import arch_on_piers, block_on_base

STEP = 0.02
TIME = STEP * np.arange(101)
WAVE = np.sin(2.0 * np.pi * TIME) * np.exp(-((TIME - 1.0) ** 2))  # g; 2 s, about 1 Hz

TAIL = """
[[history]]
record = "wave.csv"
scale = {scale}
contacts = "rigid"
integrator = "second-order"
"""
INCREMENTAL = '[incremental]\nrecords = ["*.csv"]\ncontacts = "rigid"\n'


def _project(folder, *tables, assessment=""):
    """A block template without its static stages, with a wave for a record and the tables given."""
    new_project(folder, "block", {"width_m": 0.6, "height_m": 2.4})
    text = (folder / "project.toml").read_text(encoding="utf-8")
    start, end = text.index("[pushover]"), text.index("[report]")
    text = 'scatter = 1\naccuracy = "fast"\n' + text[:start] + assessment + text[end:] + "".join(tables)
    (folder / "project.toml").write_text(text, encoding="utf-8")
    np.savetxt(folder / "wave.csv", np.column_stack([TIME, 0.5 * WAVE]), delimiter=",", fmt="%.8f")
    return load_project(folder)


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dynamic") / "block"
    project = _project(folder, TAIL.format(scale=0.58), TAIL.format(scale=6.0))
    return outcome_of(project)


def test_histories_of_both_states_and_records(outcome):
    assert outcome.complete
    assert list(outcome.results.states) == ["original", "base ruotata 20 mrad"]
    peak = 0.5 * abs(WAVE).max()
    for state in plain(outcome.results)["states"].values():
        weak, strong = state["history"]
        assert weak["record"] == "wave × 0.58"
        assert weak["pga_g"] == pytest.approx(0.58 * peak, rel=1e-6)
        assert (weak["collapsed"], weak["time_of_collapse_s"]) == (False, None)
        assert strong["collapsed"]
        assert strong["residual_displacement_m"] is None
        assert 0.0 < strong["time_of_collapse_s"] <= TIME[-1] + FREE + 2 * STEP
        assert "turned" in strong["reason"]
        curve = np.array(weak["curve"]["displacement_m"])
        assert curve[0] == 0.0
        assert weak["peak_displacement_m"] == abs(curve).max() > 0.01
        assert weak["residual_displacement_m"] == curve[-1]
        # the control point is a corner of the top: it is lifted too
        least = weak["peak_displacement_m"]
        assert least < weak["farthest_m"] < 1.2 * least and 0.0 < weak["farthest_left_m"] < least
        assert strong["farthest_m"] > least and strong["farthest_left_m"] is None
        at = weak["curve"]["time_s"].index(weak["time_of_peak_s"])
        assert abs(curve[at]) == weak["peak_displacement_m"]


def test_energy_balance_closes(outcome):
    """What is left over is little, and the weights gained what they were lifted by, from the shapes alone."""
    weights = np.array([block.weight_kN for block in outcome.results.geometry.blocks])
    for state in plain(outcome.results)["states"].values():
        for entry in state["history"]:
            energy = entry["energy"]
            assert abs(energy["residual_kNm"]) < 0.01 * energy["input_kNm"]
            taken = sum(energy[f"{name}_kNm"] for name in ("friction", "impact", "viscous", "integrator"))
            assert entry["integrator_share"] <= abs(energy["integrator_kNm"]) / taken
            start, end = (
                np.array(each)[:, 1] for each in (state["configuration"], entry["final_configuration"])
            )
            assert energy["potential_kNm"] == pytest.approx(weights @ (end - start), rel=1e-6, abs=1e-9)


def test_the_window_scale_and_step_of_a_motion(tmp_path):
    window = "window_s = [1.5, 2.0]\ntime_step_s = 0.01\n"
    project = _project(tmp_path / "block", TAIL.format(scale=-2.0), window)
    (motion,) = history_motions(project)
    whole = read_record(tmp_path / "block" / "wave.csv").acceleration
    inside = -2.0 * whole[75:101]
    assert motion.pga == abs(inside).max() < motion.original.pga
    np.testing.assert_allclose(motion.record.acceleration[::2], inside, atol=1e-15)
    assert (motion.start, motion.record.time_step, motion.record.duration) == (1.5, 0.01, pytest.approx(0.5))
    assert "leaves out the peak" in motion.notes[0]
    copy(tmp_path / "block" / "wave.csv", tmp_path / "block" / "up.csv")
    edit(tmp_path / "block", "window_s = [1.5, 2.0]", 'window_s = "arias"\nvertical_record = "up.csv"')
    (motion,) = history_motions(load_project(tmp_path / "block"))
    begin = read_record(tmp_path / "block" / "wave.csv").strong_window()[0]
    assert 0.0 <= motion.start - begin < STEP
    np.testing.assert_allclose(motion.vertical.acceleration, motion.record.acceleration, atol=1e-12)


@pytest.mark.parametrize(
    ("step", "vertical_step"),
    [(0.02, 0.04), (0.02, 0.008), (0.02, 0.03), (0.01, 0.04), (0.02, 0.02)],
    ids=["coarser", "finer", "no multiple", "a finer analysis", "the same"],
)
def test_a_vertical_record_of_another_step_shakes_at_its_own_instants(tmp_path, step, vertical_step):
    """v = 0.1 g/s t is its own broken line at any step, and its own least-squares line: at 1.5 s + t it is known.

    1.5 s is no multiple of 0.04 s or 0.008 s: cut at the first sample inside the window v would be that of 20 or 4 ms
    later.
    """
    time = vertical_step * np.arange(round(2.4 / vertical_step) + 1)
    vertical = f'vertical_record = "up.csv"\nwindow_s = [1.5, 1.9]\ntime_step_s = {step}\n'
    _project(tmp_path / "block", TAIL.format(scale=2.0))
    np.savetxt(tmp_path / "block" / "up.csv", np.column_stack([time, 0.1 * time]), delimiter=",")
    edit(tmp_path / "block", "scale = 2.0\n", f"scale = 2.0\n{vertical}")
    (motion,) = history_motions(load_project(tmp_path / "block"))
    assert motion.vertical.acceleration.size == motion.record.acceleration.size
    np.testing.assert_allclose(
        motion.vertical.acceleration, 2.0 * 0.1 * (1.5 + motion.record.time), atol=1e-9
    )


@pytest.mark.parametrize(
    ("extra", "named"),
    [
        ("window_s = [0.5, 9.0]\n", r"history\[1\].*wave.csv.*window"),
        ("damping_ratio = 0.05\n", r"history\[1\]\.damping_ratio"),
        ('vertical_record = "short.csv"\n', r"history\[1\]\.vertical_record.*short.csv"),
        ('vertical_record = "knock.csv"\n', r"knock.csv: .* of 0.02 s .*PGA of 1 g; write time_step_s = 0.005,"),
        ("time_step_s = 0.25\n", r"history\[1\]: wave.csv: a step of 0.25 s .* write time_step_s = 0.02, its own"),
        ("time_step_s = 9.0\n", r"history\[1\]: wave.csv: a step of 9 s does not keep its PGA"),
        ('[incremental]\nrecords = ["knock.csv"]\ntime_step_s = 0.01\n', r"incremental: knock.csv: a step of 0.01 s"),
    ],
)  # fmt: skip
def test_motions_that_do_not_fit_are_refused_by_key(tmp_path, extra, named):
    _project(tmp_path / "block")
    np.savetxt(tmp_path / "block" / "short.csv", np.column_stack([TIME, WAVE])[:50], delimiter=",")
    # one sample, between those at 0.01 s
    knock = np.column_stack([0.005 * np.arange(401), np.arange(401) == 201])
    np.savetxt(tmp_path / "block" / "knock.csv", knock, delimiter=",")
    path = tmp_path / "block" / "project.toml"
    path.write_text(path.read_text(encoding="utf-8") + TAIL.format(scale=1.0) + extra, encoding="utf-8")
    with pytest.raises(ProjectError, match=named):
        read_motions(load_project(tmp_path / "block"))


def test_a_coarse_step_is_refused_though_its_samples_have_the_peak(tmp_path):
    """A rise and fall in 0.2 s each is a broken line at 0.1 s too: no instant of it would be followed in between."""
    _project(tmp_path / "block", TAIL.format(scale=1.0), "time_step_s = 0.1\n")
    pulse = np.column_stack([TIME, np.interp(TIME, [0.0, 0.2, 0.4], [0.0, 0.3, 0.0])])
    np.savetxt(tmp_path / "block" / "wave.csv", pulse, delimiter=",")
    with pytest.raises(ProjectError, match=r"a step of 0\.1 s"):
        history_motions(load_project(tmp_path / "block"))
    edit(tmp_path / "block", "time_step_s = 0.1", "time_step_s = 0.04")
    assert history_motions(load_project(tmp_path / "block"))[0].record.time_step == 0.04


def test_a_scale_to_what_no_ground_does_is_refused(tmp_path):
    project = _project(tmp_path / "block", TAIL.format(scale=-100.0))
    with pytest.raises(ProjectError, match=r"history\[1\]\.scale: makes a PGA of 4\d\.\d g; write less"):
        history_motions(project)


def test_records_of_one_name_are_refused_before_they_are_one_record_of_the_fragility(tmp_path):
    """[incremental] took files of one name in two folders, [campaign] refused them."""
    project = _project(tmp_path / "block", INCREMENTAL)
    for name, factor in (("one", 0.5), ("other", np.cos(TIME))):
        (project.folder / name).mkdir()
        np.savetxt(project.folder / name / "wave.csv", np.column_stack([TIME, factor * WAVE]), delimiter=",")
    edit(project.folder, "*.csv", "*/wave.csv")
    with pytest.raises(ProjectError, match=r'incremental\.records: two records are called "wave"; rename'):
        read_motions(load_project(project.folder))


def _motion(record):
    return BaseMotion(record, record, record.pga, 1.0)


@pytest.fixture
def setting():
    table = HistoryTable(record="r", contacts="rigid", integrator="second-order")
    return Setting(table, ControlTable(name="top", point_m=(0.6, 2.4)))


def test_a_motion_that_ends_in_mid_swing_goes_on_freely(setting):
    """The parts join: time goes on evenly, displacement without a jump; a record that ends at rest has one part."""
    model = block_on_base(0.6, 2.4)
    response = respond(
        cut := Shaking(model, _motion(Record(0.5 * WAVE[:60], STEP, "cut")), setting, model.initial)
    )
    assert len(response.parts) > 1 and not response.last.velocities[-1].any()
    searched = respond(cut, to_rest=False)
    assert 1 <= len(searched.parts) < len(response.parts)
    np.testing.assert_allclose(np.diff(response.time), STEP)
    jumps = abs(np.diff(response.displacement))
    assert jumps[59] < 2.0 * jumps[[58, 60]].max()
    assert response.positions.shape == (response.time.size, 2, 3)
    gentle = respond(replace(cut, motion=_motion(Record(0.2 * WAVE, STEP, "gentle"))))
    assert len(gentle.parts) == 1


def test_a_search_runs_the_motion_of_a_history():
    """To the digit: errors a hundred times as large kept a wall with an opening standing at all levels of a band."""
    model, motion = arch_on_piers(voussoirs=7, courses=3), _motion(Record(0.3 * WAVE, STEP, "wave"))
    setting = Setting(
        HistoryTable(record="r", contacts="rigid"), ControlTable(name="top", point_m=(0.0, 1.36))
    )
    whole, searched = (
        respond(Shaking(model, motion, setting, model.initial), to_rest=rest) for rest in (True, False)
    )
    assert whole.parts[0].halvings > 0 and 10 < searched.time.size <= whole.time.size
    np.testing.assert_array_equal(searched.positions, whole.positions[: searched.time.size])


def test_a_history_tells_its_vertical_record_and_its_peak(setting):
    """It names none where none shakes: then no column of the table is printed."""
    model, quiet = block_on_base(0.6, 2.4), Record(0.1 * WAVE, STEP, "quiet")
    both = replace(_motion(quiet), vertical=Record(-0.03 * WAVE, STEP, "up"))
    one, two = (
        response.history(Shaking(model, motion, setting, model.initial, "drawn")).numbers
        for motion in (both, _motion(quiet))
    )
    assert (one.vertical_record, one.vertical_pga_g) == ("up", pytest.approx(0.03 * abs(WAVE).max()))
    assert not {"vertical_record", "vertical_pga_g"} & two.model_fields_set


PULSE = """[incremental]
records = ["pulse.csv"]
vertical_records = ["up.csv"]
contacts = "rigid"
states = ["original"]
[campaign]
records = ["pulse.csv"]
vertical_records = ["up.csv"]
contacts = "rigid"
shares = [0.0]
"""


def _pulsed(folder, tables, *names):
    """The block under a pulse a of 3 s, and files of those names with 0.8 a downward."""
    write_block(folder, f'scatter = 1\naccuracy = "fast"\n{block()}{TURNED}{tables}')
    time = 0.02 * np.arange(201)
    pulse = np.where((time > 0.1) & (time < 3.1), 0.2, 0.0)
    np.savetxt(folder / "pulse.csv", np.column_stack([time, pulse]), delimiter=",")
    for name in names:
        np.savetxt(folder / name, np.column_stack([time, -0.8 * pulse]), delimiter=",")
    return load_project(folder)


def test_a_set_of_records_is_scaled_with_its_vertical_ones(tmp_path):
    """Under a long pulse a block of slenderness α falls from a = α(1 − 0.8 a) on, in both directions and analyses."""
    project = _pulsed(tmp_path / "block", PULSE, "up.csv")
    outcome = outcome_of(project)
    alpha, found = 0.6 / 4.2, outcome.results
    [row], levels = found.states["original"].incremental.records, found.campaign.combinations
    for each in (*row.signs, *levels):
        assert each.lowest_collapse_g == pytest.approx(alpha / (1.0 + 0.8 * alpha), rel=0.04)
    filled = {table.name: table for table in tables(found)}
    for name, each in (("incremental", row), ("campaign_records", found.campaign.records[0])):
        assert (each.vertical_record, each.vertical_pga_g) == ("up", pytest.approx(0.16))
        assert {"vertical_record", "vertical_pga_g"} <= set(filled[name].columns)


@pytest.mark.parametrize("key", ["incremental", "campaign"])
def test_vertical_records_are_as_many_as_the_records(tmp_path, key):
    both = PULSE.replace(f'[{key}]\nrecords = ["pulse.csv"', f'[{key}]\nrecords = ["pulse.csv", "other.csv"')
    project = _pulsed(tmp_path / "block", both, "up.csv", "other.csv")
    with pytest.raises(ProjectError, match=rf"{key}\.vertical_records: 1 files for 2 records"):
        read_motions(project)


@pytest.mark.parametrize("tables", [PULSE, '[[history]]\nrecord = "pulse.csv"\nvertical_record = "up.csv"\n'])
def test_a_record_is_not_its_own_vertical_one(tmp_path, tables):
    project = _pulsed(tmp_path / "block", tables.replace("up.csv", "pulse.csv"))
    with pytest.raises(ProjectError, match="is the horizontal record itself"):
        read_motions(project)


def test_both_components_of_a_station_have_its_one_vertical_record(tmp_path):
    """Each file counted once: two records were refused with "1 files for 2 records"."""
    both = PULSE.replace('["pulse.csv"]', '["pulse.csv", "other.csv"]').replace(
        '["up.csv"]', '["up.csv", "up.csv"]'
    )
    project = _pulsed(tmp_path / "block", both, "up.csv", "other.csv")
    for motion in set_motions(project, "incremental"):
        assert motion.told_vertical == {"vertical_record": "up", "vertical_pga_g": pytest.approx(0.16)}


def test_thinned_curves_keep_their_shape():
    noise = np.random.default_rng(3).normal(size=30_011)
    kept = thinned(noise)
    assert kept.size <= 2000
    assert {0, noise.size - 1, int(noise.argmax()), int(noise.argmin())} <= set(kept.tolist())
    assert (np.diff(kept) > 0).all()
    np.testing.assert_array_equal(thinned(noise[:1500]), np.arange(1500))


def test_the_peak_of_a_collapse_is_the_largest_before_the_last_turn():
    displacement = np.array([0.0, 1.0, -2.0, 1.5, 3.0, 9.0])
    assert sustained_peak(displacement, collapsed=True) == 2
    assert sustained_peak(displacement, collapsed=False) == 5
    assert sustained_peak(np.array([0.0, 1.0, 2.0]), collapsed=True) == 0


PUSHOVER = """
[pushover]
contacts = ["rigid"]
directions = ["+x"]
increment_m = 0.05
control = "in alto a destra"

[assessment]
limit_states = ["SLC"]
confidence_factor = 1.0
model = "none"
spectrum = "record"

"""


def test_the_records_own_spectrum_as_demand(tmp_path):
    """a_g,NC = PGA · S_e(T_NC)/S_e,record(T_NC) with S_e(T) = 4π²d/T² (paper §7.1), at the damping of SLC (10 %)."""
    project = _project(tmp_path / "block", TAIL.format(scale=1.0), assessment=PUSHOVER)
    outcome = outcome_of(project)
    check = plain(outcome.results)["states"]["original"]["capacity"]["+x"]["SLC"]
    record = read_record(tmp_path / "block" / "wave.csv")
    spectrum = RecordSpectrum(record.acceleration, record.time_step, 0.10)
    assert check["demand_a_g_g"] == pytest.approx(record.pga)
    needed = 4.0 * np.pi**2 * check["d_star_m"] / check["T_s"] ** 2 / 9.80665
    assert check["a_g_g"] == pytest.approx(
        record.pga * needed / spectrum.acceleration(check["T_s"]), rel=1e-9
    )
    assert check["zeta_E"] == pytest.approx(check["a_g_g"] / record.pga)
    assert outcome.results.spectra["SLC"].damping == 0.10
    assert any("the maximum over [T_0, T]" in note for note in check["notes"])


def test_an_artificial_record_follows_its_spectrum(tmp_path):
    spectrum = ElasticSpectrum(0.334, 2.40, 0.36, "B")
    (tmp_path / "artificial.csv").write_bytes((examples()["triumphal_arch"] / RECORD).read_bytes())
    record = read_record(tmp_path / "artificial.csv")
    assert (record.time_step, record.duration) == (pytest.approx(0.01), pytest.approx(15.0))
    periods = np.linspace(0.15, 2.0, 60)
    ratio = response_spectrum(record.acceleration, record.time_step, periods)[0] / spectrum.acceleration(
        periods
    )
    assert ratio == pytest.approx(1.0, abs=0.11)


def test_a_failed_history_makes_the_run_incomplete_and_keeps_the_rest(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise ConvergenceError(message("step 3: no solution"))

    monkeypatch.setattr(response, "time_history", refuse)
    project = _project(tmp_path / "block", TAIL.format(scale=1.0), INCREMENTAL)
    outcome = outcome_of(project)
    assert not outcome.complete
    assert outcome.results.states["original"].history[0].reason == "step 3: no solution"
    assert outcome.results.states["original"].incremental.fragility.pga_collapse_g is None
    assert outcome.results.states[project.states[1]].pushdown["rigid"].movement_m


def test_free_motion_is_followed_to_rest_and_what_still_moves_is_told(tmp_path, monkeypatch):
    """Two seconds do not bring the block to rest, which are what is followed where no more is allowed."""
    project = _project(tmp_path / "block", TAIL.format(scale=1.0), 'states = ["original"]\n')
    rests = outcome_of(project).results
    monkeypatch.setattr(response, "TAILS", 1)
    moving = outcome_of(project).results
    [told] = [each for each in moving.quality.warnings if "blocks still move" in each]
    assert "residual displacement are not known" in told
    assert not [each for each in rests.quality.warnings if "blocks still move" in each]
    ends = [each.states["original"].history[0].residual_displacement_m for each in (moving, rests)]
    assert abs(ends[0]) > 1e-3 > abs(ends[1])
