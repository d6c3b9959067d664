"""An arm in µm, mm, m or km is one arm: same rows, shares and verdict, to the last word."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from known.arms import FEW

from rankdrop.codec import record_of
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.family import derived_in_units, polynomials_in_units
from rankdrop.exact.letters import sign_of
from rankdrop.families.derivation import NOT_DERIVED
from rankdrop.families.record import exact_of
from rankdrop.families.slices import telling_slices
from rankdrop.results.analysis import Analysis
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import known_analysis, known_names, shipped
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Joint, JointKind, Robot, geometry
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.lost import lost_sentences
from rankdrop.units import in_units, out_of_units, scale_lengths
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.explain import explain

UNITS = {"µm": 6, "mm": 3, "km": -3}
"""Power of ten that numbers in metres are multiplied by."""
FAST = ("stanford", "scara", "puma560", "planar3r")
QUICK = [(name, unit) for name in FAST for unit in UNITS if name != "puma560" or unit == "µm"]
SLOW = [("puma560", "mm"), ("puma560", "km")] + [(name, unit) for name in FEW if name not in FAST for unit in UNITS]
SLOW += [(name, "mm") for name in ("rcrrrr", "gen3", "hc10", "xarm6", "tiago")]
"""That every arm in its own unit is the same to the last bit is tried below: these are for what is said of it."""
SLIDING = ("stanford", "scara", "fetch8", "rcrrrr")


@cache
def arm(name: str) -> Robot:
    return open_robot(name)


@cache
def analysed(name: str, unit: str, starts: int) -> Analysis:
    return analyze(scale_lengths(arm(name), UNITS.get(unit, 0)), starts=starts, exact="on" if name in FAST else "auto")


_LENGTH = re.compile(r"(\d[\d.]*(?:e[+−]?\d+)?) (rad/m|m/rad|m)\b")


def in_metres(sentence: str, power: int) -> str:
    """A sentence with its lengths, pitches and rates of an arm scaled by 10^power as those of the arm."""

    def moved(match: re.Match[str]) -> str:
        value = float(match[1].replace("−", "-")) * 10.0 ** (power if match[2] == "rad/m" else -power)
        return f"{value:.3g} {match[2]}".replace("-", "−")

    return _LENGTH.sub(moved, sentence)


def said(analysis: Analysis, power: int) -> dict[str, Any]:
    """What an analysis says, without the numbers that carry a length; those are turned back into metres."""
    slides = [joint.kind is JointKind.PRISMATIC for joint in analysis.robot.variables]
    families = []
    for family in analysis.families:
        record = record_of("family", family)
        record["lost_words"] = [in_metres(one, power) for one in record["lost_words"]]
        record["lost_freedoms"] = [(one.kind, one.frame.axes, one.everywhere) for one in family.lost_freedoms]
        record["pinned"] = [
            [one.number, [f"{v * 10.0 ** (-power * slides[one.number - 1]):.12g}" for v in one.values]]
            for one in family.pinned
        ]
        record["witness"] = [
            f"{v * 10.0 ** (-power * slide):.12g}" for v, slide in zip(family.witness, slides, strict=True)
        ]
        if any(slides):  # coefficients carry a length
            record["equations"] = record["terms"] = [
                [[term.kind, term.harmonics, term.powers, term.shift] for term in one.terms] for one in family.equations
            ]
        families.append(record)
    record = analysis.to_dict()
    exact = analysis.exact
    assert exact is not None
    return {
        "coranks": record["coranks"],
        "families": families,
        "notes": record["notes"],
        "verified": analysis.verified,
        "exact": None if exact.status == NOT_DERIVED else [  # time ran out: it does on a busy machine
            exact.status, [one.exact is not None for one in analysis.families], len(exact.disagreements),
        ],
    }  # fmt: skip


def check_same(name: str, unit: str, starts: int) -> None:
    metres, other = analysed(name, "m", starts), analysed(name, unit, starts)
    mine, theirs = said(metres, 0), said(other, UNITS[unit])
    for key in mine:
        assert mine[key] == theirs[key] or (key == "exact" and None in (mine[key], theirs[key])), key
    assert other.settings.length_scale == pytest.approx(metres.settings.length_scale * 10.0 ** UNITS[unit], rel=1e-12)
    assert other.residual().holds(other.settings.tolerances) or not metres.sound_and_complete


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.by_hand_at("puma560-\\xb5m")
@pytest.mark.parametrize(("name", "unit"), QUICK)
def test_rows_and_shares_do_not_depend_on_the_unit(name: str, unit: str) -> None:
    check_same(name, unit, 500)


@pytest.mark.by_hand
@pytest.mark.parametrize(("name", "unit"), SLOW)
def test_other_kinds_of_arms_do_not_depend_on_the_unit(name: str, unit: str) -> None:
    check_same(name, unit, 2_000)


@cache
def derived(name: str, unit: str) -> Conditions:
    return conditions(scale_lengths(arm(name), UNITS.get(unit, 0)), points=100)


def check_exact(name: str, unit: str) -> None:
    power = UNITS[unit]
    metres, other = derived(name, "m"), derived(name, unit)
    if not (metres.complete and other.complete):
        pytest.skip("time ran out")
    assert metres.verdict == other.verdict
    assert [one.id for one in metres.families] == [one.id for one in other.families]
    for mine, theirs in zip(metres.families, other.families, strict=True):
        exact, other_exact = exact_of(mine), exact_of(theirs)
        assert (mine.name, mine.dimension, exact.rank_check) == (theirs.name, theirs.dimension, other_exact.rank_check)
        polynomials = polynomials_in_units(exact, metres.robot), polynomials_in_units(other_exact, other.robot)
        assert [one.text() for one in polynomials[0]] == [one.text() for one in polynomials[1]]
        assert exact.pins == other_exact.pins
        witness = derived_in_units(theirs, other.robot).witness
        assert mine.witness == pytest.approx(out_of_units(metres.robot, witness), abs=1e-9)
        told, other_told = (lost_sentences(one.lost_freedoms) for one in (mine, theirs))
        assert list(told) == [in_metres(one, power) for one in other_told]
        if metres.letters:
            assert mine.texts == theirs.texts
    assert metres.explained == other.explained
    assert metres.not_real == other.not_real
    assert metres.assumptions == other.assumptions
    assert list(metres.letters) == list(other.letters)
    for letter, value in metres.letters.items():
        assert other.letters[letter] == pytest.approx(value * 10.0**power, rel=1e-12)


@pytest.mark.spread(2)
@pytest.mark.by_hand_at("puma560-\\xb5m")
@pytest.mark.slow_at("puma560", "stanford")
@pytest.mark.parametrize(("name", "unit"), QUICK)
def test_exact_conditions_do_not_depend_on_the_unit(name: str, unit: str) -> None:
    pytest.importorskip("flint")
    check_exact(name, unit)


@pytest.mark.by_hand
@pytest.mark.parametrize(("name", "unit"), SLOW)
def test_exact_conditions_of_other_kinds_of_arms_do_not_depend_on_the_unit(name: str, unit: str) -> None:
    pytest.importorskip("flint")
    check_exact(name, unit)


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize("unit", UNITS)
def test_an_arm_in_its_own_unit_is_the_same_to_the_last_bit(unit: str) -> None:
    """Of every arm of the catalogue; everything else rests on this."""
    other_bits, other_reach, off, long, other_limits = [], [], [], [], []
    for name in known_names():
        one, other = in_units(arm(name)), in_units(scale_lengths(arm(name), UNITS[unit]))
        if (geometry(one) != geometry(other)).any():
            other_bits.append(name)
        if reach(one) != reach(other):
            other_reach.append(name)
        if not np.abs(geometry(one) - geometry(scale_lengths(arm(name), -one.exponent))).max() < 1e-14:
            off.append(name)
        if not 10**-0.5 <= reach(one) <= 10**0.5:
            long.append(name)
        limits = [[(joint.lower, joint.upper) for joint in robot.joints] for robot in (one, other)]
        if limits[0] != limits[1]:
            other_limits.append(name)
    assert (other_bits, other_reach, off, long, other_limits) == ([], [], [], [], [])


def names(analysis: Analysis) -> list[tuple[str, str, int, str]]:
    return [(one.id, one.name, one.dimension, f"{one.soundness}") for one in analysis.families]


@pytest.mark.spread(2)
@pytest.mark.by_hand_at("0.0002808988764044944")
@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.4 / 1424, 0.4e-3, 0.0254, 1 / 0.0254, 0.28, 2.8, 77.0, 3.3e5])
def test_an_arm_of_any_size_has_the_same_families(factor: float) -> None:
    """0.4 mm long, in inches, in numbers that nobody means: no row is lost, none is unnamed."""
    stanford = arm("stanford")
    joints = tuple(stretched(joint, factor) for joint in stanford.joints)
    home = stanford.home.copy()
    home[:3, 3] *= factor
    found = analyze(replace(stanford, joints=joints, home=home), starts=500, exact="on")
    assert names(found) == names(analysed("stanford", "m", 500))
    assert found.verified


def stretched(joint: Joint, factor: float) -> Joint:
    screw, frame = joint.screw.copy(), joint.frame.copy()
    frame[:3, 3] *= factor
    if joint.kind is JointKind.PRISMATIC:
        return replace(joint, frame=frame, lower=joint.lower * factor, upper=joint.upper * factor)
    screw[:3] *= factor
    return replace(joint, frame=frame, screw=screw)


@pytest.mark.slow
@pytest.mark.parametrize("unit", ["m", *UNITS])
@pytest.mark.parametrize("travel", [np.inf, 1e6])
def test_slides_without_limits_are_sampled_by_the_reach_of_the_links(travel: float, unit: str) -> None:
    """±1e6 m, as a mobile base has it, hid every family that the exact side has."""
    base = arm("planar2r")
    rail = Joint("rail", JointKind.PRISMATIC, np.array([1.0, 0, 0, 0, 0, 0]), -travel, travel)
    robot = scale_lengths(replace(base, name="rail", joints=(rail, *base.joints)), UNITS.get(unit, 0))
    assert reach(robot) == pytest.approx(reach(base) * 10.0 ** UNITS.get(unit, 0))
    found = analyze(robot, starts=200, exact="on")
    rows = [(one.corank, one.dimension, [pin.number for pin in one.pinned]) for one in found.families]
    assert rows == [(1, 1, [2, 3])]
    assert found.verified
    assert found.exact is not None
    assert found.exact.status == "agrees"
    assert found.families[0].exact is not None


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize("ends", [(-1e6, 1e6), (-np.inf, np.inf), (0.0, 1e6), (0.3, np.inf)])
def test_limits_far_beyond_the_arm_change_no_row(ends: tuple[float, float]) -> None:
    stanford = arm("stanford")
    slide = replace(stanford.joints[2], lower=ends[0], upper=ends[1])
    free = replace(stanford, joints=(*stanford.joints[:2], slide, *stanford.joints[3:]))
    assert reach(free) == pytest.approx(0.154)  # d2, all that the links have
    found = analyze(free, starts=500, exact="on")
    assert [(one.name, one.dimension) for one in found.families] == [
        (one.name, one.dimension) for one in analysed("stanford", "m", 500).families
    ]
    assert found.verified


def asked(name: str) -> list[np.ndarray]:
    """A regular configuration, a very singular one, and a witness of each kind of family."""
    robot, rng = arm(name), np.random.default_rng(3)
    return [rng.uniform(-1, 1, robot.n), np.zeros(robot.n), *(np.array(one.witness) for one in shipped(name).families)]


def explained(robot: Robot, q: np.ndarray, power: int) -> list[Any]:
    """What is said of a configuration, lengths and rates turned back into metres."""
    found = explain(robot, q)
    unit = np.where([joint.kind is JointKind.PRISMATIC for joint in robot.variables], 10.0**-power, 1.0)
    nearest = found.far.nearest

    def digits(values: Any) -> list[float]:
        return [round(float(value), 6) + 0.0 for value in np.ravel(values)]

    return [
        found.verdict, in_metres(found.reason, power), found.rank.rank, digits(found.rank.sigma),
        [(met.family.name, met.source, digits(met.residual)) for met in found.met], digits(found.focus * unit),
        [one.words for one in found.relations],
        [in_metres(one, power) for one in found.lost.words], digits(found.lost.directions), digits(found.lost.weakest),
        [one.words for one in found.blame.smallest], [one.numbers for one in found.blame.circuits],
        [(one.number, one.gain, one.order, one.receptors, one.within_limits, digits(one.step * unit[one.number - 1]))
         for one in found.escape.single],
        digits(np.abs(found.escape.best_direction.delta) * unit), found.escape.avoidable_reason,
        found.escape.boundary_reason, [(one.family.name, digits(one.distance)) for one in found.far.families],
        None if nearest is None else (digits(nearest.distance), digits(np.array(nearest.q) * unit)),
    ]  # fmt: skip


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("name", ["stanford", "puma560", "scara"])
def test_what_is_said_of_a_configuration_does_not_depend_on_the_unit(name: str, unit: str) -> None:
    power = UNITS[unit]
    robot = scale_lengths(arm(name), power)
    slides = [joint.kind is JointKind.PRISMATIC for joint in robot.variables]
    for q in asked(name):
        there = np.where(slides, q * 10.0**power, q)
        for mine, theirs in zip(explained(arm(name), q, 0), explained(robot, there, power), strict=True):
            assert mine == theirs, q


@pytest.mark.parametrize("unit", UNITS)
def test_slices_of_joint_space_do_not_depend_on_the_unit(unit: str) -> None:
    drawn = []
    for power in (0, UNITS[unit]):
        robot = scale_lengths(arm("stanford"), power)
        task = resolve_task(None, robot)
        known = known_analysis(robot, task)
        assert known is not None
        slices = telling_slices(robot, task, known.families, most=2)
        lengths = [np.where([number == 3 for number in one.joints], 10.0**-power, 1.0) for one in slices]
        drawn.append([
            (one.joints, one.filled, [(trace.family, len(trace.curves), len(trace.points)) for trace in one.traces],
             [round(float((curve * length).sum()), 4) for trace in one.traces for curve in trace.curves])
            for one, length in zip(slices, lengths, strict=True)
        ])  # fmt: skip
    assert drawn[0] == drawn[1]
    assert any(traces for _, _, traces, _ in drawn[0])


@pytest.mark.parametrize("power", [-6, -3, 0, 3, 6])
def test_signs_of_lengths_do_not_depend_on_the_unit(power: int) -> None:
    """a2² of an arm of 1 µm is 2e-13, and not zero."""
    pytest.importorskip("flint")
    chain = exact_chain(scale_lengths(arm("puma560"), power))
    letter = chain.ring.letter_half
    assert sign_of(chain, letter["a2"] ** 2) == 1
    assert sign_of(chain, letter["a3"] ** 2 - letter["d3"] ** 2) == -1
    assert sign_of(chain, letter["a2"] - letter["d4"]) == 0
