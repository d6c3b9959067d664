"""The equations that bind the coupled joints of a family: fitted circuit by circuit until they are sound."""

from __future__ import annotations

import numpy as np

from rankdrop.families.elsewhere import elsewhere
from rankdrop.families.fit import Budget, Ground, circuits, cutting, holds, hypersurface, vanishing_spaces
from rankdrop.families.library import Kind
from rankdrop.families.minors import minors
from rankdrop.families.row import on_combinations
from rankdrop.families.sampling import Supply
from rankdrop.families.twins import gathered_tangent
from rankdrop.family.equation import Equation
from rankdrop.family.system import System
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Array, JointKind

EXTRA = 3  # equations beyond the codimension that may be added to cut strangers off
SEED = 12  # points at which ranks are looked at
ROUNDS = 4  # of solutions at special places: of a row of a general 8R one in 400 is regular


def residual_equations(supply: Supply, budget: Budget, *, thorough: bool) -> tuple[Equation, ...] | None:
    """Sound residual equations of a family with one combination of its linear values.

    Circuits are fitted in order of size, and an equation is kept when it raises the rank of the gradients. Once the
    rank is the codimension, the equations are solved from random starts. Solutions that are not singular ("strangers":
    the equations of two circuits may meet in more than the family) are cut off by further equations. Where single
    circuits have too high a degree (projections of a curve have), low-degree equations in all joints are tried.

    Args:
        supply: points of the family.
        budget: work that may be spent on fits.
        thorough: also cut strangers off, and try all joints together: much more work.

    Returns:
        The equations, or None where they are out of reach.
    """
    ground, joints = _ground(supply, budget)
    chosen, spare = _from_circuits(supply, ground, joints)
    reached = _rank(supply, chosen)
    if reached > supply.signature.residual:  # more than the signature promises: families meet here
        return None
    if reached == supply.signature.residual:
        equations = _cut(supply, ground, chosen, spare, joints if thorough else ())
        if equations is not None:
            return equations
    return _from_ideal(supply, ground, joints) if thorough and len(joints) > 1 else None


def circuit_equations(supply: Supply, budget: Budget) -> tuple[Equation, ...] | None:
    """The quick part of `residual_equations`: equations of single circuits where they are sound as they are."""
    ground, joints = _ground(supply, budget)
    chosen, _ = _from_circuits(supply, ground, joints)
    if _rank(supply, chosen) != supply.signature.residual:
        return None
    tested, strangers = _strangers(supply, chosen)
    return tuple(chosen) if tested and not len(strangers) else None


def _ground(supply: Supply, budget: Budget) -> tuple[Ground, tuple[int, ...]]:
    """What fits of a family stand on, and the joints (from 0) they bind."""
    setting = supply.setting
    bound = np.abs(supply.linear.covectors).sum(axis=0) > 0
    twins = tuple(one for one in setting.twins if not bound[one.first] and not bound[one.second])
    seconds = {one.second for one in twins}
    joints = tuple(j for j in supply.signature.coupled if j not in supply.linear.pivots and j not in seconds)
    kinds = tuple(
        Kind.ANGLE if periodic else Kind.LENGTH if joint.kind is JointKind.PRISMATIC else Kind.BOTH
        for joint, periodic in zip(setting.robot.variables, setting.robot.periodic, strict=True)
    )
    highest = 4 if setting.task.m == 6 else 6
    return Ground(supply, setting.robot.n, kinds, highest, budget, setting.tolerances, twins), joints


def _from_circuits(
    supply: Supply, ground: Ground, joints: tuple[int, ...]
) -> tuple[list[Equation], list[Equation]]:
    """Equations of circuits that raise the rank of the gradients, and those that do not."""
    chosen: list[Equation] = []
    spare: list[Equation] = []
    for circuit in circuits(gathered_tangent(supply.tangent[:SEED], ground.twins), joints):
        equation = hypersurface(ground, circuit)
        if equation is None:
            continue
        raised = _rank(supply, [*chosen, equation])
        (chosen if raised > _rank(supply, chosen) else spare).append(equation)
        if raised >= supply.signature.residual:
            break
    return chosen, spare


def _told(equations: list[Equation], strangers: Array) -> list[int]:
    """Equations that tell most strangers from the family, in their own order."""
    share = [float(np.mean(np.abs(equation(strangers)) > 1e-4)) for equation in equations]
    return [i for i, s in enumerate(share) if s > 0.2 and s > 0.8 * max(share)]


def _cut(
    supply: Supply, ground: Ground, chosen: list[Equation], spare: list[Equation], joints: tuple[int, ...]
) -> tuple[Equation, ...] | None:
    """Add equations until no stranger is left: circuits not used so far, short minors, then fitted ones."""
    asked = False
    for _ in range(EXTRA + 2):
        tested, strangers = _strangers(supply, chosen)
        if not tested:
            return None
        if not len(strangers):
            return tuple(chosen)
        if not asked and not _told(spare, strangers):
            moving = tuple(j for j in supply.signature.coupled if j not in supply.linear.pivots)
            more = minors(supply.setting, supply.linear, supply.values, moving, ground.highest, supply.rng)
            spare = spare + [equation for equation in more if holds(equation, supply.q)]
            asked = True
        told = _told(spare, strangers)
        if told:
            chosen.append(spare.pop(told[0]))
            continue
        fitted = cutting(ground, strangers, joints) if len(joints) > 1 else None
        if fitted is None:
            return None
        chosen.append(fitted)
    return None


def _from_ideal(supply: Supply, ground: Ground, joints: tuple[int, ...]) -> tuple[Equation, ...] | None:
    """Low-degree equations in all joints together."""
    need = supply.signature.residual
    for basis in vanishing_spaces(ground, joints):
        chosen: list[Equation] = []
        for equation in basis:
            if _rank(supply, [*chosen, equation]) > _rank(supply, chosen):
                chosen.append(equation)
        if _rank(supply, chosen) > need:
            return None
        if _rank(supply, chosen) == need:
            sound = _selected(supply, chosen, [equation for equation in basis if equation not in chosen])
            if sound is not None:
                return sound
    return None


def _selected(supply: Supply, chosen: list[Equation], spare: list[Equation]) -> tuple[Equation, ...] | None:
    """Add equations of the basis until no stranger is left."""
    for _ in range(EXTRA + 1):
        tested, strangers = _strangers(supply, chosen)
        if not tested:
            return None
        if not len(strangers):
            return tuple(chosen)
        told = _told(spare, strangers)
        if not told:
            return None
        chosen.append(spare.pop(told[0]))
    return None


def _rank(supply: Supply, equations: list[Equation]) -> int:
    """Codimension the equations give within the linear conditions: gradient rank at most of a few points."""
    if not equations:
        return 0
    slopes = System(tuple(equations)).jacobian(supply.q[:SEED]) @ supply.linear.along
    return int(np.median((np.linalg.svd(slopes, compute_uv=False) > 1e-6).sum(axis=1)))


def _strangers(supply: Supply, equations: list[Equation]) -> tuple[int, Array]:
    """Solutions from random starts, and those of them that are not singular; many starts, and starts at special places,
    before it says none."""
    setting, tested = supply.setting, 0
    strangers = np.zeros((0, setting.robot.n))
    for count in (200, 800):
        q, good = on_combinations(
            setting, supply.linear, tuple(equations), supply.signature.residual, [supply.values], count, supply.rng
        )
        q = q[good]
        sigma = singular_values(setting.robot, q, setting.task)
        tested, strangers = tested + len(q), q[sigma[:, setting.rank] > setting.tolerances.singular]
        if len(strangers):
            return tested, strangers
    for _ in range(ROUNDS if tested else 0):
        _, strangers = elsewhere(setting, supply.linear, [supply.values], tuple(equations), {}, supply.rng)
        if len(strangers):
            break
    return tested, strangers
