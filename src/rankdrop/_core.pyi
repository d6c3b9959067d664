"""The compiled core: batched kernels over rows of configurations. Arrays are float64, C-contiguous."""

from typing import Literal, overload

import numpy as np
from numpy.typing import NDArray

_A = NDArray[np.float64]
_I = NDArray[np.int32]

class Chain:
    @property
    def variables(self) -> int: ...

class View:
    @property
    def m(self) -> int: ...

def make_chain(
    *,
    screws: _A,
    turns: list[int],
    frames: _A,
    variable: list[int],
    multiplier: _A,
    offset: _A,
    variables: int,
) -> Chain: ...
def make_view(
    chain: Chain, *, axes: int, origin: int, point: list[float], rows: list[int], factors: list[float]
) -> View: ...
def pose(chain: Chain, q: _A, out: _A | None = None, *, threads: int = 0) -> _A: ...
def jacobian(chain: Chain, view: View, q: _A, out: _A | None = None, *, threads: int = 0) -> _A: ...
def pose_one(robot: object, q: object, out: object, view: View | None, /) -> _A | None: ...
def sigma_one(robot: object, q: object, out: object, view: View | None, /) -> _A | None: ...
def decompose_one(robot: object, q: object, view: View | None, /) -> tuple[_A, _A, _A] | None: ...
def jacobian_one(robot: object, q: object, out: object, view: View | None, /) -> _A | None: ...
def derivative_one(robot: object, q: object, out: object, view: View | None, /) -> _A | None: ...
def keep(robot: object, chain: Chain, world: View) -> None: ...
def let_go(robot: int) -> None: ...
def derivative(chain: Chain, view: View, q: _A, out: _A | None = None, *, threads: int = 0) -> _A: ...
def singular_values(chain: Chain, view: View, q: _A, out: _A | None = None, *, threads: int = 0) -> _A: ...
def decompose(chain: Chain, view: View, q: _A, threads: int = 0) -> tuple[_A, _A, _A]: ...
def block(chain: Chain, view: View, q: _A, rank: int, threads: int = 0) -> tuple[_A, _A, _A, _A, _A]: ...
@overload
def svd(a: _A, vectors: Literal[True] = True, threads: int = 0) -> tuple[_A, _A, _A]: ...
@overload
def svd(a: _A, vectors: Literal[False], threads: int = 0) -> _A: ...

class AimSettings: ...

def make_aim(
    *,
    rows: list[int],
    length: float,
    point: list[float],
    with_tip: bool,
    free: int,
    heading: int,
    joints: list[float],
) -> AimSettings: ...
def aim_errors(chain: Chain, aim: AimSettings, poses: _A, q: _A) -> _A: ...
def aim_steps(chain: Chain, view: View, aim: AimSettings, q: _A, errors: _A) -> _A: ...
def aim_newton(
    chain: Chain, view: View, aim: AimSettings, poses: _A, q: _A, *, close: float, rounds: int, far: bool
) -> tuple[_A, NDArray[np.int64]]: ...
class Displacement: ...

def make_displacement(
    *, rows: list[int], row_scale: list[float], joints: list[float], point: list[float], axes: _A, home: _A
) -> Displacement: ...
def back_to_start(
    chain: Chain,
    six: View,
    displacement: Displacement,
    q: _A,
    *,
    weak: float,
    longest: float,
    still: float,
    rounds: int,
) -> tuple[_A, _A]: ...
def poses_at(poses: _A, places: _A) -> _A: ...

class SearchSettings:
    def __init__(
        self,
        *,
        method: int,
        rank: int,
        iterations: int,
        singular: float,
        target: float,
        stationary: float,
        seed: int,
        scale: _A,
        limits: _A | None,
        tie: float,
        share: float = 0.0,
        kicks: int = 2,
    ) -> None: ...

class NearestSettings:
    def __init__(
        self,
        *,
        rank: int,
        evaluations: int,
        singular: float,
        target: float,
        centre: _A,
        scale: _A,
        limits: _A | None,
        still: float = 1e-9,
        polish: bool = True,
    ) -> None: ...

def search(
    chain: Chain,
    view: View,
    starts: _A,
    settings: SearchSettings,
    *,
    first: int = 0,
    history: bool = False,
    threads: int = 0,
) -> tuple[_A, _A, NDArray[np.int8], NDArray[np.int32], _A | None, _A | None, bool]: ...
def nearest(
    chain: Chain, view: View, starts: _A, settings: NearestSettings, *, threads: int = 0
) -> tuple[_A, _A, _A, NDArray[np.int32]]: ...

def set_feet(
    chain: Chain, view: View, starts: _A, *, centre: _A, scale: _A, turn: _A, farthest: float
) -> tuple[_A, NDArray[np.int8], _A]: ...

class Families:
    @property
    def variables(self) -> int: ...

def links(chain: Chain, q: _A, out: _A | None = None, *, threads: int = 0) -> _A: ...
def readable(bases: _A) -> _A: ...
def rows_of_text(text: str, separator: str, columns: int) -> _A | None: ...
def make_families(
    *,
    variables: int,
    shift: list[float],
    turns: list[int],
    turning: list[int],
    m: list[float],
    angle: list[int],
    a: list[float],
    b: list[float],
    powers: list[int],
    terms: list[int],
    equations: list[int],
    corank: list[int],
    scale: list[float],
    periodic: list[int],
    coupled: list[int],
    pins: list[int],
    pinned: list[int],
    at: list[int],
    values: list[float],
) -> Families: ...

class MonitorSettings:
    def __init__(
        self,
        *,
        generic: int,
        singular: float,
        on: float,
        loose: float,
        start: float,
        stop: float,
        beyond: bool,
        rates: list[float],
    ) -> None: ...

def monitor(
    chain: Chain, view: View, families: Families, q: _A, settings: MonitorSettings, *, threads: int = 0
) -> tuple[_A, _I, _I, _I, _A, _A, _A, _A]: ...

def spread(chain: Chain, view: View, families: Families, settings: MonitorSettings) -> None: ...
@overload
def equations(families: Families, q: _A, *, slopes: Literal[True] = True, threads: int = 0) -> tuple[_A, _A]: ...
@overload
def equations(families: Families, q: _A, *, slopes: Literal[False], threads: int = 0) -> _A: ...

class ZeroSettings:
    def __init__(
        self, *, iterations: int, step: float, still: float, enough: float, cut: float, along: list[float]
    ) -> None: ...

def zeros(families: Families, q: _A, settings: ZeroSettings, *, threads: int = 0) -> tuple[_A, _A]: ...

class FootSettings:
    def __init__(
        self, *, leading: int, iterations: int, returns: int, still: float, longest: float, cut: float, flattest: float,
        farthest: float,
        target: list[float], scale: list[float], periodic: list[int], columns: list[int], limits: _A | None
    ) -> None: ...

def feet(families: Families, q: _A, settings: FootSettings, *, threads: int = 0) -> _A: ...
def promised(
    values: _A, tensor: _A, tau: _A, mixed: _A, *, rounds: int, effort: int, exact: float, threads: int = 0
) -> tuple[_A, _A, _A, _A]: ...

class Watcher:
    def __init__(self, chain: Chain, view: View, families: Families, settings: MonitorSettings) -> None: ...
    def step(
        self, q: _A, velocity: _A | None
    ) -> tuple[_A, int, int, int, int, float, float, float, float, float, float] | None: ...
    def apart(self) -> tuple[_A, _A, _A]: ...

def threads_kept() -> int: ...
def instruction_sets() -> list[str]: ...
def instruction_set() -> str: ...
def choose_instruction_set(name: str) -> bool: ...

class EnclosureSettings:
    def __init__(self, *, rank: int, length: float, radius: float, repeats: float, scale: _A, arm: _A) -> None: ...

def enclose(
    chain: Chain, view: View, q: _A, half: _A | None, settings: EnclosureSettings, *, threads: int = 0
) -> tuple[NDArray[np.int8], _A, _A, _A, _A, _A, _A]: ...
def largest_ball(
    chain: Chain, views: list[View], settings: list[EnclosureSettings], q: _A
) -> tuple[int, float]: ...
def series(screws: _A, rates: _A, axes: int, origin: int, order: int) -> _A: ...
def ball(
    chain: Chain,
    view: View,
    q: _A,
    matters: NDArray[np.bool_],
    settings: EnclosureSettings,
    *,
    inner: float,
    enough: float,
    smallest: float,
    budget: int,
    keep: bool,
) -> tuple[float, int, bool, _A, _A]: ...

class Split:
    def __init__(
        self,
        *,
        a: _A,
        b: _A,
        lower: _A,
        upper: _A,
        depth: _I,
        curvature: _A,
        rounding: float,
        slope: float,
        further: int,
        top: int,
    ) -> None: ...
    @property
    def trees(self) -> int: ...

def cover(
    split: Split, begin: int, end: int, *, threads: int = 0
) -> tuple[NDArray[np.uint16], _I, int, int]: ...
def split_level(split: Split, number: int) -> tuple[_A, float, _A, _A]: ...
def split_shape(split: Split, number: int, place: _I) -> _A: ...
def judge_leaves(
    split: Split, leaves: _I, halvings: int, *, parts: int = ..., threads: int = 0
) -> NDArray[np.int8]: ...
