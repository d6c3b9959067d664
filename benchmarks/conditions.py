"""Exact conditions: CPU time on one core of the verb, beside SymPy on the same determinant and KG's other methods.

Every figure comes from a process of its own: CPU seconds after the imports, and the most memory it ever held. SymPy is
no part of rankdrop; where it is not installed its columns are empty.
"""

from __future__ import annotations

import importlib.util
import json
import resource
import shutil
import subprocess
import sys
import time
from typing import Any

import measure  # first: sets the number of threads

SIX = ("anthropomorphic", "puma560", "irb140", "vx300s", "stanford", "ur3", "ur5", "ur10", "ur5e", "z1", "xarm6")
LIMIT = 60.0
"""No process may take longer [s]."""


def verb(arm: str, coranks: int | None) -> dict[str, Any]:
    """`conditions`, without the numeric cloud and without special lengths: what is derived."""
    from rankdrop.robot.open import open_robot
    from rankdrop.verbs.conditions import conditions

    robot = open_robot(arm)
    conditions(open_robot("scara"), points=0, special=False)  # what is imported on first use
    begin = time.process_time()
    found = conditions(robot, coranks=coranks, points=0, special=False, seconds=LIMIT)
    return {
        "s": time.process_time() - begin, "method": found.method, "families": len(found.families),
        "done": found.complete,
    }  # fmt: skip


def method(arm: str, name: str) -> dict[str, Any]:
    """One of KG's methods for comparison, corank 1."""
    from rankdrop.errors import OptionError
    from rankdrop.exact.arm.chain import exact_chain
    from rankdrop.exact.methods import derive
    from rankdrop.robot.open import open_robot

    derive(exact_chain(open_robot("scara")), "determinant")
    begin = time.process_time()
    try:
        found = derive(exact_chain(open_robot(arm)), name, seconds=LIMIT / 2)
    except OptionError as error:
        return {"s": time.process_time() - begin, "families": 0, "done": False, "says": error.what}
    return {"s": time.process_time() - begin, "families": len(found.conditions), "done": found.complete}


def sympy(arm: str, half: int) -> dict[str, Any]:
    """det J by SymPy: factor(trigsimp(det)) from the same entries, or factor of the same half-angle polynomial."""
    import sympy as sp
    from sympy.polys.matrices import DomainMatrix

    from rankdrop.exact.arm.chain import exact_chain
    from rankdrop.robot.open import open_robot

    chain = exact_chain(open_robot(arm))
    angles = {f"t{j}": sp.Symbol(f"t{j}") for j in chain.ring.revolute}
    if half:
        polynomial = chain.ring.to_half(chain.ring.determinant(chain.columns)).f
        text = str(polynomial).replace("^", "**")
        begin = time.process_time()
        factors = sp.factor_list(sp.sympify(text, locals=angles))[1]
        moving = {*angles.values(), *(sp.Symbol(f"q{j}") for j in chain.ring.prismatic)}
        kept = [f for f, _ in factors if f.free_symbols & moving and not _unit(sp, f)]
        return {"s": time.process_time() - begin, "families": len(kept), "done": True}
    waves = {sp.Symbol(f"{w}{j}"): getattr(sp, k)(sp.Symbol(f"t{j}")) for j in chain.ring.revolute
             for w, k in (("c", "cos"), ("s", "sin"))}  # fmt: skip
    names = {str(symbol): symbol for symbol in waves}
    entries = [[sp.sympify(str(x).replace("^", "**"), locals=names) for x in column] for column in chain.columns]
    begin = time.process_time()
    matrix = DomainMatrix.from_Matrix(sp.Matrix(entries))  # over polynomials: SymPy's quickest way
    determinant = matrix.domain.to_sympy(matrix.det()).xreplace(waves)
    found = sp.factor(sp.trigsimp(determinant))
    seconds = time.process_time() - begin
    moving = {*angles.values(), *(sp.Symbol(f"q{j}") for j in chain.ring.prismatic)}
    kept = [f for f in sp.Mul.make_args(found) if f.free_symbols & moving]
    return {"s": seconds, "families": len(kept), "done": True}


def _unit(sp: Any, f: Any) -> bool:
    """Whether a factor is 1 + t²: without a real zero."""
    return bool(len(f.free_symbols) == 1 and sp.expand(f - 1 - next(iter(f.free_symbols)) ** 2) == 0)


def singular(arm: str, _what: Any) -> dict[str, Any]:
    """`factorize` of Singular on the same half-angle polynomial; its own processor time, start included."""
    from rankdrop.exact.arm.chain import exact_chain
    from rankdrop.robot.open import open_robot

    chain = exact_chain(open_robot(arm))
    polynomial, _ = chain.ring.to_half(chain.ring.determinant(chain.columns))
    names = [*(f"t{j}" for j in chain.ring.revolute), *(f"q{j}" for j in chain.ring.prismatic)]
    program = f"ring r = 0,({','.join(names)}),dp; list l = factorize({polynomial}); size(l[1]) - 1; quit;"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(["Singular", "-q"], input=program, capture_output=True, text=True, check=True, timeout=LIMIT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"s": seconds, "families": int(done.stdout.split()[-1]), "done": True}


JOBS = {"verb": verb, "method": method, "sympy": sympy, "singular": singular}


def alone(job: str, arm: str, what: Any = None) -> dict[str, Any]:
    """One job in a process of its own."""
    command = [sys.executable, __file__, "--job", json.dumps([job, arm, what])]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=2 * LIMIT)
    except subprocess.TimeoutExpired:
        return {"s": None, "families": None, "done": False, "MB": None}
    if done.returncode:
        missing = "No module named 'sympy'" in done.stderr
        return {"s": None, "families": None, "done": False, "MB": None} if missing else sys.exit(done.stderr)
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


def import_seconds() -> float:
    """CPU time of a process that only imports what a derivation needs."""
    program = "import time; import rankdrop, flint; print(time.process_time())"
    return float(subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout)


def row(arm: str, what: str, ours: dict[str, Any], target: float | None, **peers: Any) -> measure.Row:
    """One line of the table; peers are texts."""
    told = {"sympy trig": "", "sympy half": "", "singular half": ""} | peers
    return {
        "arm": arm, "what": what, "s": ours["s"], "target": target or "", "families": ours["families"],
        "finished": ours["done"], "MB": ours["MB"], **told, "of the target": ours["s"] / target if target else "",
        "claimed": target is not None,
    }  # fmt: skip


def _told(found: dict[str, Any]) -> str:
    return "–" if found["s"] is None else f"{found['s']:.2f} s, {found['families']} factors"


def _missing() -> dict[str, str]:
    """What there is nothing to compare with."""
    absent = {} if importlib.util.find_spec("sympy") else {"SymPy": "pip install sympy"}
    return absent | ({} if shutil.which("Singular") else {"Singular": "apt-get install singular"})


def main() -> None:
    """Corank 1 of six-axis arms, of redundant arms, all coranks, and KG's methods."""
    quick = measure.quick()
    rows = []
    for arm in SIX[:2] if quick else SIX:
        peers = {"sympy trig": _told(alone("sympy", arm, 0)), "sympy half": _told(alone("sympy", arm, 1))}
        if shutil.which("Singular"):
            peers["singular half"] = _told(alone("singular", arm))
        rows.append(row(arm, "corank 1", alone("verb", arm, 1), 0.2, **peers))
        rows.append(row(arm, "determinant alone", alone("method", arm, "determinant"), None))
    wanted = [("pa10", 1, 1.0), ("iiwa14", 1, 1.0), ("canadarm2", 1, 3.0), ("panda", 1, 3.0),
              ("pa10", None, 15.0), ("iiwa14", None, 15.0), ("canadarm2", None, 15.0)]  # fmt: skip
    for arm, coranks, target in wanted[:1] if quick else wanted:
        rows.append(row(arm, "corank 1" if coranks else "all coranks", alone("verb", arm, coranks), target))
    from rankdrop.exact.methods import METHODS

    for arm in () if quick else ("pa10", "canadarm2"):
        rows += [row(arm, name, alone("method", arm, name), None) for name in METHODS]
    measure.report(
        f"exact conditions, CPU time on one core, imports ({import_seconds():.2f} s) not counted",
        rows, ratio="of the target", target=1.0, at_most=True, missing=_missing(),
    )  # fmt: skip


if __name__ == "__main__":
    if "--job" in sys.argv:
        name, *rest = json.loads(sys.argv[sys.argv.index("--job") + 1])
        answer = JOBS[name](*rest)
        print(json.dumps(answer | {"MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))
    else:
        main()
