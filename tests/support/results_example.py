"""A hand-made results dictionary: an arch of five voussoirs on two supports, original and settled.

Geometry and curves follow from a few formulas; capacities, checks and spectra are those that the program finds of them.
"""

import itertools
import json
import math
from functools import cache
from typing import Any

import numpy as np

from assessment.analyses.capacity import checks_of, curve_of
from assessment.ntc.capacity_curve import CurveFit, capacity_curve, fit_curve
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.verification import verify
from assessment.results.schema import FORMAT, Results
from assessment.results.schema.checks import Capacity, Count
from assessment.results.schema.part import plain
from assessment.results.summary import EMPTY, summary_of

G = 9.80665
SETTLED = "right support 20 mm"
HAZARD = {"SLD": (0.104, 2.33, 0.28), "SLV": (0.261, 2.36, 0.35), "SLC": (0.334, 2.40, 0.36)}  # L'Aquila
SPECTRA = {limit: ElasticSpectrum(*values, "B") for limit, values in HAZARD.items()}
DAMPING = {"SLD": 0.05, "SLV": 0.08, "SLC": 0.10}


def results_example(language: str = "it") -> dict[str, Any]:
    """Return a fresh results dictionary; change it at will."""
    made: dict[str, Any] = json.loads(_results(language))
    return made


@cache
def _results(language: str) -> str:
    states = {
        "original": _state(0.0, 0.153, 0.192),
        SETTLED: _state(0.02, 0.131, 0.161) | {"settlement": _settlement(), "pushdown": _pushdown()},
    }
    content = {
        "format": FORMAT,
        "assesto": "0.1.0",
        "title": "Arco di prova" if language == "it" else "Trial arch",
        "inputs": {"project.toml": "0" * 64, "geometry.dxf": "1" * 64},
        "model": {
            "blocks": 7, "movable_blocks": 5, "joints": 6, "unknowns": 18,
            "contact_points": 24, "weight_kN": 11.5 * 0.1 * _area() + 0.5, "self_weight_stable": True,
            "warnings": ["layer PIERS: 2 gaps of 0.9 mm were taken as closed"],
        },
        "geometry": _geometry(),
        "echo": _echo(language),
        "states": states,
        "spectra": {limit: _spectrum(limit) for limit in SPECTRA},
        "comparison": [
            {
                "state": SETTLED,
                "direction": direction,
                "limit_state": "SLC",
                "static_pga_g": _pga(states, SETTLED, direction),
                "static_reduction": 1.0
                - _pga(states, SETTLED, direction) / _pga(states, "original", direction),
                "dynamic_pga_g": None,
                "dynamic_reduction": None,
            }
            for direction in ("+x", "-x")
        ],
        "convergence": {
            "tolerance": 0.05,
            "rows": [
                {
                    "state": name, "direction": direction, "halvings": 2, "alpha_0_error": 0.0,
                    "d_0_error_m": d_0_error, "a_g_error_g": 0.002,
                    "relative_error": None if d_0_error is None else 0.012, "met": d_0_error is not None,
                    "levels": {"alpha_0": [0.15, 0.15, 0.15]},
                }
                for name, direction, d_0_error in (("original", "+x", 0.0023), (SETTLED, "-x", None))
            ],
            "incremental": [
                {
                    "state": SETTLED, "record": "wave", "pga_collapse_error_g": 0.043, "order": 1.0,
                    "relative_error": 0.19, "met": False,
                    "levels": {"pga_collapse_g": [0.226, 0.2045, 0.194]},
                }
            ],
        },
        "quality": {
            "solves": 210,
            "worst_equilibrium_residual": 3.2e-10,
            "worst_penetration_m": 1.1e-9,
            "worst_complementarity": 4.5e-10,
            "worst_cone_violation": 2.0e-11,
            "warnings": [],
            "by_stage": [
                {
                    "state": name, "stage": stage, "solves": 70, "worst_equilibrium_residual": 3.2e-10,
                    "worst_penetration_m": 1.1e-9, "worst_complementarity": 4.5e-10,
                    "worst_cone_violation": 2.0e-11,
                }
                for name, stage in (("original", "pushover"), (SETTLED, "pushdown"), (SETTLED, "pushover"))
            ],
        },
        "timing_s": {"pushdown": 0.4, "pushover": 0.9},
        "software": {
            "version": "0.1.0", "python": "3.11.7", "platform": "Linux", "packages": {"numpy": "2.4.6"},
        },
    }  # fmt: skip
    without = Results.model_validate(content | {"summary": EMPTY})
    return json.dumps(content | {"summary": plain(summary_of(without))})


def _frames(index: list[int], movement: float) -> dict[str, Any]:
    """Return frames at some points of a path, all of them alike and without forces."""
    nothing = [None] * len(index)
    return {"index": index, "configuration": [_configuration(movement)] * len(index),
            "force_kN": nothing, "centre": nothing, "met": []}  # fmt: skip


def _rings() -> list[np.ndarray]:
    angles = np.linspace(math.pi, 0.0, 6)

    def at(radius: float, angle: float) -> list[float]:
        return [radius * math.cos(angle), radius * math.sin(angle)]

    voussoirs = [
        np.array([at(1.0, a), at(1.3, a), at(1.3, b), at(1.0, b)]) for a, b in itertools.pairwise(angles)
    ]
    supports = [np.array([[x, -0.2], [x + 0.4, -0.2], [x + 0.4, 0.0], [x, 0.0]]) for x in (-1.35, 0.95)]
    return [supports[0], *voussoirs, supports[1]]


def _area() -> float:
    return sum(_shoelace(ring) for ring in _rings()[1:-1])


def _shoelace(ring: np.ndarray) -> float:
    x, z = ring.T
    return float(abs(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2.0)


def _geometry() -> dict[str, Any]:
    rings = _rings()
    roles = ["left", None, None, None, None, None, "right"]
    layers = ["BASE_LEFT", "PIERS", "ARCH", "ARCH", "ARCH", "PIERS", "BASE_RIGHT"]
    blocks = [
        {
            "vertices_m": ring.tolist(), "centroid_m": ring.mean(axis=0).tolist(), "depth_m": 0.1,
            "layer": layer, "handle": f"2{index}", "support": role,
            "vertical_load_kN": 0.5 if index == 3 else 0.0,
            "weight_kN": 11.5 * 0.1 * _shoelace(ring) + (0.5 if index == 3 else 0.0),
        }
        for index, (ring, role, layer) in enumerate(zip(rings, roles, layers, strict=True))
    ]  # fmt: skip
    faces = [ring[:2] for ring in rings[1:6]] + [rings[5][2:]]
    joints = [
        {
            "blocks": [i, i + 1], "ends_m": face.tolist(), "middle_m": [face.mean(axis=0).tolist()] * 2,
            "faces_m": [face.tolist()] * 2, "friction": 0.6, "depth_m": 0.1,
            "compressive_strength_kN_m2": None,
        }
        for i, face in enumerate(faces)
    ]  # fmt: skip
    return {
        "blocks": blocks, "controls": [{"name": "C1", "point_m": [0.0, 1.236], "block": 3}], "joints": joints,
        "joint_tolerance_m": 1e-4, "gravity_m_s2": G,
    }  # fmt: skip


def _configuration(movement: float) -> list[list[float]]:
    share = np.linspace(0.0, 1.0, 7)
    tilt = -0.3 * movement * np.sin(math.pi * share)
    return np.column_stack([movement * share, -movement * share**2, tilt]).tolist()


def _mechanism(sign: float, alpha_0: float, e_star: float, gamma_star: float) -> dict[str, Any]:
    rings = _rings()
    centroids = np.array([ring.mean(axis=0) for ring in rings])
    rotation = np.array([0.0, -0.8, 0.5, 0.5, -0.6, -0.6, 0.0]) * sign
    displacement = np.zeros((7, 3))
    pivots = [rings[1][0], rings[2][1], rings[4][0], rings[5][2]]
    position = np.zeros(2)
    for block in range(1, 6):  # a chain of rotations from the left support: blocks 2-3 and 4-5 move as one
        pivot = {1: pivots[0], 2: pivots[1], 4: pivots[2]}.get(block)
        if pivot is not None:
            before = displacement[block - 1]
            arm = pivot - centroids[block - 1]
            position = before[:2] + before[2] * np.array([-arm[1], arm[0]])
            anchor = pivot
        arm = centroids[block] - anchor
        displacement[block, 2] = rotation[block]
        displacement[block, :2] = position + rotation[block] * np.array([-arm[1], arm[0]])
    displacement /= abs(displacement[3, 0])  # block 3 holds the control point
    return {
        "point": 0, "alpha": alpha_0, "control_displacement_x": float(displacement[3, 0]), "hinges": 4,
        "e_star": e_star, "gamma_star": gamma_star, "displacements": displacement.tolist(),
        "hinge_points_m": [pivot.tolist() for pivot in pivots], "sliding_joints": [5],
        "moving_weight_kN": 1.25, "friction_work_kNm": None,
    }  # fmt: skip


def _state(movement: float, alpha_0: float, d_0: float) -> dict[str, Any]:
    pushover, capacity = {}, {}
    for direction, factor in (("+x", 1.0), ("-x", 1.07)):
        a0, d0, e_star, gamma_star = alpha_0 * factor, d_0 * factor, 0.75 + movement, 0.66 + movement
        sense = 1.0 if direction == "+x" else -1.0
        displacement = np.linspace(0.0, d0, 60)
        rigid = a0 * (1.0 - displacement / d0)
        peak = 0.12 * d0
        rising = a0 * 0.86 * np.sin(np.clip(displacement / peak, 0.0, 1.0) * math.pi / 2.0)
        elastic = np.where(displacement < peak, rising, np.minimum(0.86 * a0, 0.98 * rigid))
        fit = fit_curve("trilinear", (displacement, rigid), (displacement, elastic))
        pushover[direction] = {
            "control": "C1",
            "rigid": {
                "alpha_0": a0, "alpha_onset": a0, "d_0_m": d0, "reached_zero": True, "lost": False,
                "end": "α = 0", "sliding": "associative",
                "curve": {"displacement_m": (sense * displacement).tolist(), "multiplier": rigid.tolist()},
                "d_star_m": (gamma_star * displacement).tolist(),
                "mechanism": _mechanism(sense, a0, e_star, gamma_star),
                "mechanism_configuration": _configuration(movement),
                "final_configuration": _configuration(movement), "virtual_work_alpha": a0 * 1.0004,
                "frames": _frames([0], movement),
            },
            "elastic": {
                "alpha_u": fit.alpha_u, "alpha_y": fit.alpha_y, "d_y_m": fit.d_y,
                "curve": {"displacement_m": (sense * displacement).tolist(), "multiplier": elastic.tolist()},
                "d_u_m": float(displacement[elastic.argmax()]), "peak": int(elastic.argmax()), "end": "α = 0",
                "sliding": "associative", "reached_zero": True,
                "rest_configuration": _configuration(movement),
                "peak_configuration": _configuration(movement),
                "frames": _frames(sorted({0, int(elastic.argmax())}), movement),
            },
        }  # fmt: skip
        capacity[direction] = _capacity(fit, e_star, gamma_star)
    return {
        "configuration": _configuration(movement), "settlement": None, "pushdown": {}, "pushover": pushover,
        "capacity": capacity, "history": [], "incremental": {},
    }  # fmt: skip


def _capacity(fit: CurveFit, e_star: float, gamma_star: float) -> dict[str, Any]:
    curve = capacity_curve(fit, e_star, gamma_star)
    checks = checks_of(curve, verify(curve, SPECTRA))
    found = Capacity(
        mechanism=Count(hinges=4, sliding_joints=1), notes=[], trace=[], d_0_star_m=curve.d_0_star,
        e_star=e_star, gamma_star=gamma_star, T_0_s=curve.T_0, model=fit.model, curve=curve_of(curve),
    ).with_checks({limit: checks[limit] for limit in SPECTRA})  # fmt: skip
    made: dict[str, Any] = plain(found)
    return made


def _spectrum(limit: str) -> dict[str, Any]:
    spectrum, T = SPECTRA[limit], np.unique(np.r_[0.0, np.geomspace(0.02, 4.0, 60)])
    damped = spectrum.with_damping(DAMPING[limit])
    return {
        "kind": "ground", "S": spectrum.S, "T_B_s": spectrum.T_B, "T_C_s": spectrum.T_C, "T_D_s": spectrum.T_D,
        "damping": damped.damping, "a_g_g": spectrum.ag, "F0": spectrum.F0, "Tc_star_s": spectrum.Tc_star,
        "soil": spectrum.soil, "topography": spectrum.topography, "T_s": T.tolist(),
        "S_e_g": spectrum.acceleration(T).tolist(), "S_De_m": spectrum.displacement(T).tolist(),
        "damped_S_e_g": damped.acceleration(T).tolist(), "damped_S_De_m": damped.displacement(T).tolist(),
    }  # fmt: skip


def _settlement() -> dict[str, Any]:
    return {"support": "right", "displacement_m": [0.02, -0.02], "rotation_rad": 0.0, "increment_m": 0.001}


def _pushdown() -> dict[str, Any]:
    stages = {}
    for contacts, ultimate in (("rigid", 0.065), ("elastic", 0.027)):
        movement = np.linspace(0.0, ultimate, 40)
        stages[contacts] = {
            "movement_m": movement.tolist(), "reaction_x_kN": (-0.0104 - 0.08 * movement).tolist(),
            "reaction_z_kN": (0.62 + 0.5 * movement).tolist(), "ultimate_movement_m": ultimate,
            "applied_movement_m": 0.02, "configuration": _configuration(0.02),
            "ultimate_configuration": _configuration(ultimate),
            "control_displacement_m": np.column_stack([0.5 * movement, 0.0 * movement]).tolist(),
            "end": "the structure falls", "sliding": "associative",
            "frames": _frames(list(range(len(movement))), 0.02),
        }  # fmt: skip
    return stages


def _pga(states: dict[str, Any], name: str, direction: str) -> float:
    return float(states[name]["capacity"][direction]["SLC"]["pga_g"])


def _echo(language: str) -> dict[str, Any]:
    return {
        "title": "Arco di prova",
        "geometry": {"drawing": "geometry.dxf", "unit": "mm", "depth_m": 0.1},
        "contacts": {"sliding": "associative", "collisions": True},
        "material": {"unit_weight_kN_m3": 11.5, "friction": 0.6, "normal_stiffness_kN_m3": 1.2e5},
        "layers": {"BASE_LEFT": {"support": "left"}, "BASE_RIGHT": {"support": "right"}},
        "control": [{"name": "C1", "point_m": [0.0, 1.236]}],
        "settlements": [{"name": SETTLED, **_settlement(), "to_collapse": True}],
        "pushover": {
            "contacts": ["rigid", "elastic"], "directions": ["+x", "-x"], "increment_m": 0.001,
            "control": "C1",
        },
        "assessment": {
            "limit_states": ["SLD", "SLV", "SLC"], "confidence_factor": 1.35, "behaviour_factor": 2.0,
            "model": "trilinear", "spectrum": "ntc",
            "site": {"latitude": 42.35, "longitude": 13.40, "soil": "B", "topography": "T1"},
        },
        "report": {
            "language": language, "client": "Comune <A & B>", "engineer": "ing. N. Nome",
            "location": "L'Aquila", "attachments": [],
        },
    }  # fmt: skip
