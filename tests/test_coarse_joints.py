"""The warning of elastic joints of few segments: when, in which words, and what its threshold rests on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assessment import figures
from assessment.benchmark.dynamics import shaking
from assessment.benchmark.structures import assembly, template
from assessment.cli import TEMPLATES, main
from assessment.coarse_joints import ENOUGH, coarse_joints
from assessment.model import build_model
from assessment.new_project import new_project
from assessment.project import load_project
from assessment.states import PAST_PEAK
from assessment.translation import translated
from assessment.words import words_of
from mechanics import Assembly, Block, Material, pushdown, pushover, time_history
from tests.block_project import PUSHED, block, write_block
from tests.every_stage import write_wave
from tests.structures import block_on_base, rectangle

HISTORY = '[[history]]\nrecord = "wave.csv"\ncontacts = "elastic"\n'
SEARCH = '[incremental]\nrecords = ["wave.csv"]\ncontacts = "elastic"\n'
SAID = "too few segments for the elastic contacts of"


def written(folder: Path, text: str) -> Path:
    write_wave(write_block(folder, text) / "wave.csv", 0.1)
    return folder


def warned(folder: Path) -> list[str]:
    return [text for text in build_model(load_project(folder)).warnings if SAID in text]


def test_check_and_run_name_file_key_and_remedy(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(figures, "write_figures", lambda _, folder: folder.mkdir())
    folder = written(tmp_path / "block", block(segments=4) + HISTORY)
    for command in (["check"], ["run", "--no-report"]):
        assert main([*command, str(folder)]) == 0
        [line] = [line for line in capsys.readouterr().out.splitlines() if SAID in line]
        assert line.startswith(f"warning: project.toml: geometry.segments_per_joint (4): {SAID} history: ")
        assert f'write {ENOUGH} or more, or accuracy = "standard"' in line


@pytest.mark.parametrize(
    ("segments", "tables", "tables_named"),
    [
        (ENOUGH - 1, HISTORY, "history"),
        (1, SEARCH, "incremental"),
        (8, HISTORY + SEARCH, "history, incremental"),
        (8, HISTORY.replace("elastic", "rigid") + SEARCH, "incremental"),
        (ENOUGH, HISTORY + SEARCH, None),
        (1, HISTORY.replace("elastic", "rigid") + SEARCH.replace("elastic", "rigid"), None),
        (1, PUSHED, None),
        (ENOUGH - 1, PUSHED.replace("rigid", "elastic"), "pushover"),
        (8, PUSHED.replace('"rigid"', '"rigid", "elastic"') + HISTORY, "pushover, history"),
        (ENOUGH, PUSHED.replace("rigid", "elastic"), None),
    ],
)
def test_only_elastic_analyses_on_few_segments_are_warned_of(tmp_path, segments, tables, tables_named):
    said = warned(written(tmp_path / "block", block(segments) + tables))
    assert [f"{SAID} {tables_named}:" in text for text in said] == [True] * (tables_named is not None)


@pytest.mark.parametrize(("accuracy", "warnings"), [('"fast"', 1), ('"standard"', 0), ("0.1", 0)])
def test_nothing_is_said_where_the_report_tells_the_error(tmp_path, accuracy, warnings):
    folder = written(tmp_path / "block", f"accuracy = {accuracy}\n" + block(segments=4) + HISTORY)
    assert len(warned(folder)) == warnings


PIERS = "layers.PIERS.segments_per_joint (8)"


@pytest.mark.parametrize(
    ("own", "given", "keys"),
    [
        ([None, 8, 8, None], 4, PIERS),  # every joint touches a pier, whose segments are more
        ([None, 8, 8, None], 12, f"{PIERS}, geometry.segments_per_joint (12)"),  # between the piers theirs
        ([None, 8, None, None], 4, f"geometry.segments_per_joint (4), {PIERS}"),
        ([None, 8, 8, None], 16, PIERS),
        ([None, 8, None, None], 16, None),
    ],
)
def test_the_keys_are_those_that_decide(tmp_path, own, given, keys):
    """A stack of blocks: of two the one that asks for more decides."""
    project = load_project(written(tmp_path / "block", block() + HISTORY))
    stone = Material(18.0, 0.7, 1e6)
    stack = [
        Block(rectangle(0, z, 1, z + 1), 1.0, stone, None if z else "base", segments=segments, layer="PIERS")
        for z, segments in enumerate(own)
    ]
    said = coarse_joints(project, Assembly(stack, given))
    assert [text.partition(": too few")[0] for text in said] == [f"project.toml: {keys}"] * (keys is not None)


def test_an_italian_report_says_it_in_italian(tmp_path):
    [text] = warned(written(tmp_path / "block", block(segments=4) + HISTORY + SEARCH))
    italian = translated(text, words_of({"echo": {"report": {"language": "it"}}}))
    assert italian.startswith(
        "project.toml: geometry.segments_per_joint (4): segmenti troppo pochi per i contatti elastici di "
        "history, incremental: "
    )
    assert f"scrivere {ENOUGH} o più" in italian


@pytest.mark.parametrize("name", TEMPLATES)
def test_only_templates_with_the_segments_of_the_paper_warn(tmp_path, name):
    new_project(tmp_path / name, name, {})
    assert bool(warned(tmp_path / name)) == (name in ("buttressed-arch", "triumphal-arch"))


def test_from_enough_segments_on_the_peak_of_a_motion_is_near():
    """A settled block on a soft joint: 20 % off with 4 segments, 1.3 % with 16 (of 64)."""

    shaken = shaking(1.0)(0.005 * np.arange(601))
    shaken *= 0.12 / abs(shaken).max()

    def peak(segments: int) -> float:
        model = block_on_base(0.6, 4.2, stiffness=1e5, segments=segments)
        settled = pushdown(model, "base", rotation=-0.02, increment=1.0, contacts="elastic").final
        motion = time_history(
            model, shaken, 0.005, "elastic", settled, damping_ratio=0.05, control=(0.6, 4.2)
        )
        return float(abs(motion.displacement).max())

    many = peak(4 * ENOUGH)
    assert abs(peak(ENOUGH) - many) < 0.05 * many
    assert abs(peak(ENOUGH // 4) - many) > 0.1 * many


def test_from_enough_segments_on_the_peak_of_the_multiplier_is_near():
    """An arch as drawn: 32 % too high with 4 segments, 4 % with 16 (of 64)."""
    project, drawn = template("arch"), assembly("arch")

    def peak(segments: int) -> float:
        control = project.pushover_control("+x").point_m
        model = Assembly(drawn.blocks, segments)
        return float(pushover(model, control, "+x", "elastic", 0.02, until=PAST_PEAK).multiplier.max())

    many = peak(4 * ENOUGH)
    assert many < peak(ENOUGH) < 1.06 * many
    assert peak(ENOUGH // 4) > 1.2 * many
