"""Systems of every shape are the same after they were written and read again."""

import io
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth import Exit, Mode, System

# Words of TOML, of its tables, of Python and of mathematics, and others that are odd.
NAMES = [
    "true", "false", "inf", "nan", "e", "E", "I", "_", "__init__", "x1", "X1", "flow", "modes",
    "format", "exits", "name", "slaved", "drift", "reset", "guard", "to", "period", "states", "a_b",
    "self", "print", "match", "n" * 80, "O", "l",
]  # fmt: skip
# Everything that a file can hold: control characters, quotes, other scripts, no surrogates.
labels = st.text(st.characters(exclude_categories=["Cs"]), max_size=30)
sizes = st.floats(1e-3, 1e3)
numbers = st.one_of(sizes, st.integers(-9, 9), sizes.map(lambda x: -x), st.just(5e-324))
blanks = st.sampled_from(["", " ", "\n", "\t ", "\r\n"])


@st.composite
def systems(draw) -> System:
    """A system that is right, with any of the words of this version."""
    pool = draw(st.permutations(NAMES))[: draw(st.integers(8, 14))]
    w, states, modes = pool[0], pool[1:4], pool[4:6]
    parameters, others = pool[6:8], pool[8:]
    definitions, outputs = others[: len(others) // 2], others[len(others) // 2 :]
    first, second, drifting = states

    def expression() -> str | float:
        atoms = [first, second, f"cos({w}*t)", *definitions, *parameters, "pi", "1e-3"]
        terms = draw(st.lists(st.sampled_from(atoms), max_size=4))
        if not terms:
            return draw(numbers)
        weights = [f"{draw(numbers)!r}*{term}" for term in terms]
        return draw(blanks) + draw(blanks).join(["", *(f"+{weight}" for weight in weights)])

    def entries(keys, value) -> dict:
        return {key: value() for key in keys if draw(st.booleans())}

    def constant() -> str | float:
        return draw(st.one_of(numbers, st.sampled_from(["pi/2", "-4/5", "sqrt(2)", " 1 "])))

    def way() -> Exit:
        reset = {s: expression() for s in draw(st.lists(st.sampled_from(states[:2]), unique=True))}
        if draw(st.booleans()):
            reset[drifting] = f"{drifting} + 1"
        targets = [modes[0], "stop", *([None, modes[1]] if reset else [])]
        to, name = draw(st.sampled_from(targets)), draw(st.none() | st.sampled_from(NAMES))
        return Exit(f"2 + {first} + {draw(numbers)!r}", to=to, reset=reset, name=name)

    def mode(exits) -> Mode:
        flow, slaved = {state: expression() for state in states}, {}
        if draw(st.booleans()):
            del flow[second]
            slaved[second] = draw(st.sampled_from([f"2*{first}", f"{first} - 1 = 3*{second}"]))
        own = {key: draw(st.sampled_from(["0", f"2*{first}", 3])) for key in definitions[:1]}
        return Mode(flow, exits, slaved, draw(st.sampled_from([{}, own])))

    return System(
        name=draw(labels),
        states=states,
        parameters={w: draw(st.sampled_from([2.0, "2", "pi"]))}
        | {key: constant() for key in parameters},
        definitions={key: draw(st.sampled_from([f"{w}**2 - {first}", 0.5])) for key in definitions},
        outputs=dict.fromkeys(outputs, f"abs({first}) + {drifting}"),
        period=draw(st.sampled_from([None, f"2*pi/{w}", f"4*pi/{w}"])),
        drift=draw(st.sampled_from([[], [drifting], {drifting: "2*pi"}, {drifting: 360}])),
        require={f"{w} {draw(blanks)}> 0": draw(labels)} if draw(st.booleans()) else {},
        initial=entries(states, constant),
        describe=entries([*states, w, *definitions, *outputs, "time"], lambda: draw(labels)),
        modes={
            modes[0]: mode([Exit(f"3 - {first}", to=modes[1])]),
            modes[1]: mode([way() for _ in range(draw(st.integers(0, 3)))]),
        },
    )


@pytest.mark.slow
@given(systems())
def test_a_system_is_the_same_after_reading(system):
    again = System.from_toml(system.to_toml())
    assert again == system
    assert hash(again) == hash(system)
    assert again.to_toml() == system.to_toml()
    assert pickle.loads(pickle.dumps(again)) == system
    assert again.parameter_values == system.parameter_values
    assert again.rest_state == system.rest_state
    # equality compares what is written, so a word lost in writing would not show in it
    for key in ("name", "states", "drift", "period", "parameters", "definitions", "outputs"):
        assert getattr(again, key) == getattr(system, key)
    for key in ("require", "initial", "describe", "modes"):
        assert getattr(again, key) == getattr(system, key)
        assert list(getattr(again, key)) == list(getattr(system, key))


@pytest.mark.slow
@given(systems())
def test_every_system_is_explained(system):
    file = io.StringIO()
    system.explain(file)
    lines = file.getvalue().splitlines()
    assert all(line.isprintable() for line in lines)
    assert sum(line.startswith("mode ") for line in lines) == 2


@pytest.mark.slow
@given(systems())
def test_line_ends_of_other_systems_mean_the_same(system):
    text = system.to_toml()
    assert System.from_toml("\ufeff" + text.replace("\n", "\r\n")) == system


def test_the_ready_made_system_runs_the_same():
    mole = ns.models.moling(b=0.1)
    again = System.from_toml(mole.to_toml())
    assert ns.simulate(again, periods=3).identical(ns.simulate(mole, periods=3))


def test_a_run_goes_on_with_the_system_that_it_keeps():
    run = ns.simulate(ns.models.moling(), periods=2.5)
    again = System.from_toml(run.attrs["system"])
    longer = ns.simulate(again, run, periods=1)
    assert longer.identical(ns.simulate(ns.models.moling(), run, periods=1))


def test_written_and_read_as_a_file(tmp_path):
    mole = ns.models.moling()
    path = tmp_path / "mole.toml"
    assert mole.to_toml(path) == path.read_text(encoding="utf-8")
    assert System.from_toml(path) == System.from_toml(str(path)) == mole
    mole.with_parameters(b=0.2).to_toml(str(path))  # replaces the file
    assert System.from_toml(path).parameters["b"] == 0.2
    assert [file.name for file in tmp_path.iterdir()] == ["mole.toml"]


@pytest.mark.parametrize(
    ("name", "words"),
    [("mole.txt", "ends with '.txt'"), ("mole", "no suffix"), ("no/mole.toml", "does not exist")],
)
def test_files_that_cannot_be_written(tmp_path, name, words):
    with pytest.raises(ns.OptionError, match=words):
        ns.models.moling().to_toml(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "mole.toml"
    ns.models.moling().to_toml(path)
    before = path.read_bytes()

    def fail(self, *arguments, **options):
        self.write_bytes(b"half")
        raise OSError("no space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", fail)
    with pytest.raises(OSError, match="no space"):
        ns.models.moling(b=0.2).to_toml(path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["mole.toml"]


def test_half_surrogates_are_refused_before_a_file_is_half_written():
    words = {"states": ["x"], "modes": {"m": Mode({"x": "0"})}}
    for more in (
        {"name": "\ud800"},
        {"describe": {"x": "\udc80"}},
        {"require": {"1 > 0": "\ud800"}},
    ):
        with pytest.raises(ns.ModelError, match="surrogate"):
            System(**words, **more)
