"""Where TOML text comes from, how its faults are shown, and its bounds."""

import codecs
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from effort import calls_at_most
from nonsmooth import ModelError, System
from nonsmooth.system.model.toml_text import MAX_CHARACTERS, parse_toml, read_source

DECAY = """states = ["x"]
[modes.decay.flow]
x = "-x"
"""


def refused(source) -> str:
    with pytest.raises(ModelError) as caught:
        System.from_toml(source)
    return str(caught.value)


# ---------------------------------------------------------------- sources


def test_text_and_files(tmp_path, monkeypatch):
    path = tmp_path / "d\u00e9cay.toml"
    path.write_text(DECAY, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for source in (DECAY, path, str(path), Path(path.name), path.name):
        assert System.from_toml(source).states == ("x",)


def test_a_byte_order_mark_is_no_fault(tmp_path):
    path = tmp_path / "decay.toml"
    path.write_bytes(codecs.BOM_UTF8 + DECAY.encode())
    assert System.from_toml(path) == System.from_toml("\ufeff" + DECAY) == System.from_toml(DECAY)


def test_text_has_line_breaks_and_a_path_has_none():
    assert read_source("a = 1\n") == ("a = 1\n", "")
    assert "there is no file 'a = 1'" in refused("a = 1")
    assert "one key a line" in refused("a = 1")


@pytest.mark.parametrize("source", [b"states = []\n", 3, None, ["x"], {"states": ["x"]}])
def test_other_sources_are_refused(source):
    assert f"give TOML text or the path of a file, not {type(source).__name__}" in refused(source)


def test_files_that_cannot_be_read(tmp_path):
    assert "is empty" in refused("")
    assert "there is no file" in refused(tmp_path / "no.toml")
    assert "there is no file" in refused(tmp_path / "no" / "no.toml")
    assert "cannot be read: Is a directory" in refused(tmp_path)
    assert "cannot be read" in refused("a\0b")
    assert "cannot be read" in refused("\ud800")
    long = refused("x" * 100_000)
    assert "cannot be read" in long
    assert len(long) < 400


def test_encodings_other_than_utf8(tmp_path):
    path = tmp_path / "decay.toml"
    path.write_text(DECAY, encoding="utf-16")  # as some shells write what is redirected
    assert "is UTF-16 text; TOML is UTF-8, so save it as that" in refused(path)
    path.write_bytes(b"# \xb5m\n" + DECAY.encode())
    assert "is not UTF-8 text" in refused(path)


def test_errors_name_the_file(tmp_path):
    path = tmp_path / "decay.toml"
    for text in (DECAY.replace("-x", "-y"), DECAY.replace('"-x"', "-x"), "mode = 1\n"):
        path.write_text(text, encoding="utf-8")
        assert refused(path).startswith(f"{path}: ")


# ---------------------------------------------------------------- syntax

FAULTS = [
    # text, line, column, words in the message
    ("a = 1\nx = v\n", 2, 5, "invalid value; an expression stands in quotes"),
    ("x = 2*v\n", 1, 6, "one key = value on each line"),
    ('x = "v\n', 1, 7, "a text in quotes ends on its line"),
    ("a = 1\na = 2\n", 2, 6, "this is given already"),
    ("[a]\n[a]\n", 2, 3, "cannot declare"),
    ("\n\na b = 1\n", 3, 3, "expected '='"),
    ("a = [1,\n2\n", 2, 2, "unclosed array"),
    ('a = """x\n\n', 1, 9, "unterminated string"),
    ('a = "\\q"\n', 1, 8, "unescaped"),
    ("a = 1\r\n\r\nb = x\r\n", 3, 5, "invalid value"),
    ("= 1\n", 1, 1, "invalid statement"),
    ("x=1979-02-30\n", 1, 3, "invalid date"),
]


@pytest.mark.parametrize(("text", "line", "column", "words"), FAULTS, ids=[f[0] for f in FAULTS])
def test_faults_are_shown_with_a_caret(text, line, column, words):
    message, shown, caret = refused(text).split("\n")
    assert message.startswith(f"TOML, line {line}, column {column}: ")
    assert words in message
    assert shown.strip() == text.replace("\r\n", "\n").split("\n")[line - 1].strip()
    assert caret.index("^") - 4 == column - 1


def test_nothing_that_a_terminal_obeys_is_shown():
    shown = refused('a = "\x1b[2J\n').split("\n")[1]
    assert shown.isprintable()


# ---------------------------------------------------------------- bounds

DEEP = {
    "arrays": "a = " + "[" * 50_000,
    "closed arrays": "a = " + "[" * 50_000 + "]" * 50_000,
    "inline tables": "a = " + "{a = " * 50_000,
    "after a string": 'a = ["""x"""""' + ", [" * 50_000,
    "after an escape": 'a = ["\\"", ' + "[" * 50_000,
    "after a comment": 'a = 1 # "\nb = ' + "[" * 50_000,
    "dotted": "a" + ".a" * 500_000 + " = 1",
    "quoted and dotted": '"a"' + " . 'a'" * 200_000 + " = 1",
    "header": "[a" + ".a" * 500_000 + "]",
    "inline dotted": "a = {a" + ".a" * 500_000 + " = 1}",
}


@pytest.mark.parametrize("name", DEEP)
def test_deep_nesting_is_refused_before_it_is_parsed(name, monkeypatch):
    monkeypatch.setattr(tomllib, "loads", lambda text: pytest.fail("was parsed"))
    assert "deeper than a system needs" in refused(DEEP[name] + "\n")


HARMLESS = {
    "text": "[[[[[[[[[[ a.b.c.d.e.f.g.h.i.j.k ((((( {{{{{{{{{{{",
    "comment": "[[[[[[[[[[[[[[[",
    "array of numbers": ", ".join(["1.5"] * 50),
}


def test_brackets_in_texts_and_comments_do_not_count():
    for quote in ('"', "'", '"""', "'''"):
        text = DECAY + f"[describe]\nx = {quote}{HARMLESS['text']}{quote} # {HARMLESS['comment']}\n"
        assert System.from_toml(text).describe["x"] == HARMLESS["text"]
    assert parse_toml(f"a = [{HARMLESS['array of numbers']}]")["a"] == [1.5] * 50
    assert parse_toml("".join(f"[[a.b]]\n[a.b.c{i}]\n" for i in range(50)))


UNUSUAL = {
    "quotes": '"' * 1_000_000,
    "open string": 'a = """' + '\\"""' * 50_000 + "\\",
    "open strings": "a = '''" + "''" * 80_000,
    "escapes": 'a = "' + "\\" * 200_001,
    "tables": "".join(f"[a.b{i}]\n" for i in range(18_000)),
    "integer": "a = " + "1" * 100_000,
    "hexadecimal": 'states = ["x"]\nperiod = 0x' + "f" * 100_000 + '\n[modes.m.flow]\nx = "0"',
    "modes": 'states = ["x"]\n' + "".join(f'[modes.m{i}.flow]\nx="0"\n' for i in range(6_000)),
    "states": "states = [" + ",".join(f'"x{i}"' for i in range(20_000)) + "]\n[modes.m.flow]",
    "spaces": "a" + " " * 1_000_000,
}


@pytest.mark.few(3)
@pytest.mark.parametrize("name", UNUSUAL)
def test_the_work_on_any_text_is_in_proportion_to_its_length(name):
    # up to 5 calls for a character; a pass over all of them for each would be 1e10
    with calls_at_most(20 * len(UNUSUAL[name])):
        message = refused(UNUSUAL[name] + "\n")
    assert len(message) < 5000


def test_absurdly_large_sources_are_refused(tmp_path):
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * (MAX_CHARACTERS + 1))
    for source in (path, "#\n" * MAX_CHARACTERS):
        assert "more than 10,000,000 characters" in refused(source)
    path.write_bytes("\u4e2d".encode() * (2 * MAX_CHARACTERS))
    assert "more than 10,000,000 characters" in refused(path)


# ---------------------------------------------------------------- anything

MARKS = ["[", "]", "[[", "]]", "{", "}", "=", ".", ",", '"', "'", '"""', "'''", "#", "\n", "\\",
         "a", "1", "0x", "1.5", "1979-05-27", "true", "inf", " ", "\r\n"]  # fmt: skip


@given(st.one_of(st.text(max_size=80), st.lists(st.sampled_from(MARKS)).map("".join)))
def test_any_text_is_data_or_a_model_error(text):
    try:
        found = parse_toml(text)
    except ModelError:
        return
    assert found == tomllib.loads(text)
