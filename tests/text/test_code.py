"""Code of families runs, and says what the equations say."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest

from rankdrop.algebra.ring import Ring
from rankdrop.errors import OptionError
from rankdrop.families.record import ExactConditions
from rankdrop.formula.writing import AnglePin, Condition
from rankdrop.text.code import Code

N = 5
SHIFTS = (0.0, 0.25, 0.0, 0.0, -1.5)
LETTERS = {"a2": 0.4318, "lambda": -0.0203, "d4": 0.4331}


@dataclass(frozen=True)
class Stated:
    id: str
    name: str
    corank: int
    exact: ExactConditions


def family(id: str, name: str, corank: int, pins: tuple, polynomials: tuple) -> Stated:
    return Stated(id, name, corank, ExactConditions((), (*pins, *polynomials), ()))


def families():
    ring = Ring([1, 2, 3, 5], [4], list(LETTERS))
    s, c, letter = ring.s, ring.c, ring.letter
    c23, s23 = c[2] * c[3] - s[2] * s[3], s[2] * c[3] + c[2] * s[3]
    long = ring.to_half(letter["a2"] * c[2] + letter["lambda"] * c23 - letter["d4"] * s23 * ring.q[4] ** 2 / 7).f
    half = ring.letter_half["d4"] * ring.t[5] * ring.t[2] - 3
    pins = (AnglePin(5, ("-pi/2",)), AnglePin(1, ("0", "pi/2")))
    return [
        family("k1.f1", "shoulder */ \\ \"θ2\"", 1, (), (Condition(ring, long),)),
        family("k1.f2", "elbow_3", 1, (AnglePin(3, ("0", "pi")),), ()),
        family("k2.f1", "both, θ3 = 90°", 2, pins, (Condition(ring, long), Condition(ring, half))),
    ]


@pytest.fixture(scope="module")
def code():
    return Code("test arm 7", N, families(), LETTERS, SHIFTS)


def expected(family, q):
    """Residuals by `Equation`, and by how much each may be scaled."""
    equations = [one.equation(LETTERS, N, SHIFTS) for one in family.exact.stated]
    return np.stack([equation(q) for equation in equations], axis=-1)


def assert_proportional(found, wanted):
    assert found.shape == wanted.shape
    ratio = found / wanted
    assert np.isfinite(ratio).all()
    assert ratio == pytest.approx(np.broadcast_to(ratio.reshape(-1, ratio.shape[-1])[0], ratio.shape), rel=1e-9)


def test_python_module_runs_on_numpy_alone_and_agrees(code):
    scope: dict = {}
    exec(compile(code.python(), "generated", "exec"), scope)
    q = np.random.default_rng(3).uniform(-3, 3, (4, 6, N))
    assert list(scope["FAMILIES"]) == ["k1.f1", "k1.f2", "k2.f1"]
    assert scope["NAMES"] == {"k1.f1": "shoulder */ / 'θ2'", "k1.f2": "elbow_3", "k2.f1": "both, θ3 = 90°"}
    for family in families():
        function = scope["FAMILIES"][family.id]
        assert_proportional(function(q), expected(family, q))
        assert function(q[0, 0]).shape == (expected(family, q[0, 0]).shape[-1],)
        assert "corank" in function.__doc__
        assert "[rad" in function.__doc__
    changed = scope["k1_f1"](q, a2=1.0, lambda_=0.5, d4=0.0)
    assert not np.allclose(changed, scope["k1_f1"](q))


def test_c_header_compiles_without_a_warning_and_agrees(code, tmp_path):
    compiler = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    q = np.random.default_rng(4).uniform(-3, 3, (7, N))
    (tmp_path / "arm.h").write_text(code.c(), encoding="utf-8")
    calls = "".join(
        f"{{ double r[{m}]; rankdrop_test_arm_7_{mark}(q[i], r); for (k = 0; k < {m}; ++k) printf(\"%.17g \", r[k]); }}"
        for mark, m in (("k1_f1", 1), ("k1_f2", 1), ("k2_f1", 4))
    )
    rows = ",".join("{" + ",".join(repr(float(x)) for x in row) + "}" for row in q)
    main = '#include <stdio.h>\n#include "arm.h"\n#include "arm.h"\n'
    main += f"static const double q[7][{N}] = {{{rows}}};\n"
    main += f'int main(void) {{ int i, k; for (i = 0; i < 7; ++i) {{ {calls} printf("\\n"); }} return 0; }}\n'
    (tmp_path / "main.c").write_text(main, encoding="utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]
    command = [compiler, *flags, "main.c", "-o", "main", "-lm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    printed = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True).stdout
    found = np.array([[float(x) for x in line.split()] for line in printed.splitlines()])
    wanted = np.concatenate([expected(family, q) for family in families()], axis=-1)
    assert_proportional(found, wanted)


def test_c_gradients_and_distances_are_those_of_the_residuals(code, tmp_path):
    """Gradients against central differences; distances against pinned joints' ways and |f|/|∇f|."""
    compiler = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    (tmp_path / "arm.h").write_text(code.c(), encoding="utf-8")
    marks = (("k1_f1", 1), ("k1_f2", 1), ("k2_f1", 4))
    calls = "".join(
        f"{{ double r[{m}], g[{m}][{N}]; rankdrop_test_arm_7_{mark}(q, r); rankdrop_test_arm_7_{mark}_gradient(q, g);"
        f' for (k = 0; k < {m}; ++k) {{ printf("%.17g ", r[k]); for (j = 0; j < {N}; ++j) printf("%.17g ", g[k][j]); }}'
        f' printf("%.17g ", rankdrop_test_arm_7_{mark}_distance(q)); }}'
        for mark, m in marks
    )
    main = '#include <stdio.h>\n#define RANKDROP_TEST_ARM_7_LENGTH 0.5\n#include "arm.h"\n'
    main += f"int main(void) {{ double q[{N}]; int j, k; for (;;) {{ for (j = 0; j < {N}; ++j) "
    main += f'if (scanf("%lf", q + j) != 1) return 0; {calls} printf("\\n"); }} }}\n'
    (tmp_path / "main.c").write_text(main, encoding="utf-8")
    command = [compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main", "-lm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr

    def said(q):
        text = "\n".join(" ".join(repr(float(x)) for x in row) for row in q)
        out = subprocess.run([str(tmp_path / "main")], input=text, capture_output=True, text=True, check=True).stdout
        rows = np.array([[float(x) for x in line.split()] for line in out.splitlines()])
        found, at = {}, 0
        for mark, m in marks:
            part = rows[:, at : at + m * (N + 1)].reshape(len(q), m, N + 1)
            found[mark] = part[..., 0], part[..., 1:], rows[:, at + m * (N + 1)]
            at += m * (N + 1) + 1
        return found

    q, h = np.random.default_rng(5).uniform(-3, 3, (6, N)), 1e-6
    here = said(q)
    for j in range(N):
        step = h * np.eye(N)[j]
        ahead, behind = said(q + step), said(q - step)
        for mark, _ in marks:
            slope = (ahead[mark][0] - behind[mark][0]) / (2 * h)
            np.testing.assert_allclose(here[mark][1][..., j], slope, rtol=1e-6, atol=1e-7)
    scale = np.array([1, 1, 1, 0.5, 1])
    np.testing.assert_allclose(here["k1_f2"][2], np.abs((q[:, 2] + np.pi / 2) % np.pi - np.pi / 2))
    f, slope, distance = here["k1_f1"]
    np.testing.assert_allclose(distance, np.abs(f[:, 0]) / np.linalg.norm(slope[:, 0] * scale, axis=1))
    f, slope, distance = here["k2_f1"]
    ways = [np.abs((q[:, 4] - 1.5 + np.pi / 2 + np.pi) % (2 * np.pi) - np.pi),
            np.minimum(*(np.abs((q[:, 0] - v + np.pi) % (2 * np.pi) - np.pi) for v in (0.0, np.pi / 2)))]  # fmt: skip
    most = (np.abs(f[:, 2:]) / np.linalg.norm(slope[:, 2:] * scale, axis=2)).max(axis=1)
    np.testing.assert_allclose(distance, np.sqrt(ways[0] ** 2 + ways[1] ** 2 + most**2))


def test_latex_table_holds_every_condition_and_balances(code):
    text = code.latex()
    assert r"\theta_3 \in \{0, \pi\}" in text
    assert r"elbow\_3 & 1 &" in text
    assert r"both, $\theta_{3}$ = 90$^\circ$ & 2 &" in text
    assert r"a_2 = 0.4318\,\mathrm{m}" in text
    assert r"\theta_{5} = q_{5} - 1.5\,\mathrm{rad}" in text
    bare = text.replace(r"\{", "").replace(r"\}", "")
    assert bare.count("{") == bare.count("}")
    assert bare.replace(r"\$", "").count("$") % 2 == 0
    assert text.isascii()


def test_a_family_without_a_condition_is_refused():
    with pytest.raises(OptionError, match=r"k1\.f9"):
        Code("arm", N, [family("k1.f9", "x", 1, (), ())], {})


def test_marks_that_make_the_same_name_are_refused():
    one, two = (family(mark, "x", 1, (AnglePin(3, ("0",)),), ()) for mark in ("k1.f1", "k1-f1"))
    with pytest.raises(OptionError, match="same name"):
        Code("arm", N, [one, two], {})
