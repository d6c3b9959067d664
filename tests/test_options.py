"""Options as records: bounds hold from the start, and the command line is derived from the same fields."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import signature
from threading import Thread
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
import pytest
from cyclopts import App

from rankdrop.cli.command import command
from rankdrop.errors import OptionError, RobotError
from rankdrop.options import Options, advise, allowed_values, hints, on_command_line, option, takes


@dataclass(frozen=True)
class Search(Options):
    """What a search is asked."""

    starts: Annotated[int, option("Random starts", ge=1, le=1000)] = 100
    within: Annotated[float, option("Distance from the family", unit="rad", ge=0)] | None = None
    speed: Annotated[float, option("Slowest motion", unit="m/s", gt=0)] = 0.025
    method: Annotated[Literal["lm", "gradient"], option("How")] = "lm"
    fresh: Annotated[bool, option("Derive anew")] = False
    every: Annotated[bool, option("Every row", name="--all")] = False
    only: Annotated[tuple[str, ...], option("Parts")] = ()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"starts": 0}, "not allowed; got 0; allowed: a whole number, 1 … 1000"),
        ({"starts": 1001}, "not allowed"),
        ({"starts": True}, "this value is not allowed"),
        ({"starts": 1.5}, "a whole number"),
        ({"within": -1e-9}, r"a number, at least 0 \[rad\]"),
        ({"within": float("nan")}, "not allowed"),
        ({"within": float("inf")}, "not finite"),
        ({"speed": 0}, r"a number above 0 \[m/s\]"),
        ({"method": "newton"}, "lm, gradient"),
        ({"fresh": 1}, "True or False"),
        ({"only": (1,)}, "this value is not allowed"),
    ],
)
def test_a_record_out_of_its_bounds_does_not_exist(given: dict[str, Any], words: str) -> None:
    with pytest.raises(OptionError, match=words) as caught:
        Search(**given)
    assert caught.value.where == next(iter(given))


def test_numbers_of_numpy_become_those_of_python() -> None:
    made = Search(starts=np.int64(3), within=np.float32(0.5), fresh=np.bool_(True), only=["a"])  # type: ignore[arg-type]
    assert made == Search(3, 0.5, fresh=True, only=("a",))
    assert [type(value) for value in (made.starts, made.within, made.fresh)] == [int, float, bool]


def test_keywords_count_over_the_record() -> None:
    assert Search.of(None, {"starts": 7}) == Search(7)
    assert Search.of(Search(7, 0.1), {"starts": 8}) == Search(8, 0.1)
    with pytest.raises(OptionError, match="begun: no option has this name; allowed: starts, within"):
        Search.of(None, {"begun": 1})
    with pytest.raises(OptionError, match="not allowed"):
        Search.of(Search(), {"starts": 0})


def test_a_verb_shows_the_fields_as_keywords() -> None:
    @takes(Search)
    def search(robot: str, options: Search | None = None, **given: Any) -> Search:
        return Search.of(options, given)

    assert list(signature(search).parameters) == ["robot", "options", *hints(Search)]
    assert search("arm", starts=5).starts == 5


def test_msgspec_writes_reads_and_describes_a_record() -> None:
    text = msgspec.json.encode(Search(5, 0.25))
    assert msgspec.json.decode(text, type=Search) == Search(5, 0.25)
    described = msgspec.json.schema(Search)["$defs"]["Search"]["properties"]
    assert described["starts"] == {"description": "Random starts", "type": "integer", "minimum": 1, "maximum": 1000,
                                   "default": 100}  # fmt: skip
    assert described["speed"]["unit"] == "m/s"


def parsed(*words: str) -> Search:
    """The record that a command line gives."""
    app = App(name="test")
    given: list[Search] = []

    @app.default
    @command
    def search(*, options: Search = Search()) -> int:
        given.append(options)
        return 0

    app(list(words), exit_on_error=False, print_error=False, result_action="return_value")
    return given[0]


def test_the_command_line_reads_a_record() -> None:
    made = parsed("--starts", "1_0", "--within", "180deg", "--speed=250mm/s", "--method", "gradient", "--fresh",
                  "--all", "--only", "a", "--only", "b")  # fmt: skip
    assert type(made) is Search  # equal to the record that a verb compares it with
    assert made.within == pytest.approx(np.pi)
    assert made.speed == pytest.approx(0.25)
    assert (made.starts, made.method, made.fresh, made.every, made.only) == (10, "gradient", True, True, ("a", "b"))


def test_the_command_line_refuses_what_the_record_does() -> None:
    with pytest.raises(OptionError, match="starts: this value is not allowed; got 0"):
        parsed("--starts", "0")
    with pytest.raises(RobotError, match="--within: the unit is not one that fits here; got '3mm'"):
        parsed("--within", "3mm")


def test_what_is_allowed_is_said_in_words() -> None:
    words = {name: allowed_values(hint) for name, hint in hints(Search).items()}
    assert words["within"] == "a number, at least 0 [rad]"
    assert words["method"] == "lm, gradient"


@dataclass(frozen=True)
class Seeded(Options):
    """What draws at random."""

    seed: Annotated[int, option("Seed", ge=0)] = 0


def test_rng_is_another_name_of_the_seed() -> None:
    assert Seeded.of(None, {"rng": 7}).seed == 7
    drawn = [Seeded.of(None, {"rng": np.random.default_rng(3)}).seed for _ in range(2)]
    assert drawn[0] == drawn[1] != Seeded.of(None, {"rng": np.random.default_rng(4)}).seed
    with pytest.raises(OptionError, match="rng and seed are the same option"):
        Seeded.of(None, {"rng": 7, "seed": 7})
    with pytest.raises(OptionError, match="seed: this value is not allowed"):
        Seeded.of(None, {"rng": "7"})
    with pytest.raises(OptionError, match="no option has this name"):
        Search.of(None, {"rng": 7})


def test_advice_is_typed_in_every_thread_of_a_command() -> None:
    """The viewer makes its words in threads of its server."""
    said: list[str] = []
    with on_command_line():
        thread = Thread(target=lambda: said.append(advise("task", "position")))
        thread.start()
        thread.join()
    assert said == ["--task position"]
    assert advise("task", "position") == "task='position'"


def test_a_default_out_of_its_bounds_is_noticed_at_the_first_use() -> None:
    @dataclass(frozen=True)
    class Wrong(Options):
        starts: Annotated[int, option("Random starts", ge=1)] = 0

    with pytest.raises(OptionError, match="at least 1"):
        Wrong()
