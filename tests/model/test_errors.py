"""Every bad file stands beside its full message; rewrite them with ``OBSCLI_REWRITE_ERRORS=1``, then read them."""

import os
from pathlib import Path

import pytest

from obscli.core.place import ModelError
from obscli.model.reader import load


ERRORS = Path(__file__).parents[1] / "errors"
FILES = sorted(path.name for path in ERRORS.glob("*.yaml"))


@pytest.mark.parametrize("name", FILES)
def test_message(name, monkeypatch):
    monkeypatch.chdir(ERRORS)
    with pytest.raises(ModelError) as caught:
        load(name)
    expected = Path(name).with_suffix(".txt")
    if os.environ.get("OBSCLI_REWRITE_ERRORS"):
        expected.write_text(f"{caught.value}\n", encoding="utf-8")
    assert f"{caught.value}\n" == expected.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", FILES)
def test_every_problem_has_its_place(name, monkeypatch):
    monkeypatch.chdir(ERRORS)
    with pytest.raises(ModelError) as caught:
        load(name)
    lines = (ERRORS / name).read_bytes().decode("utf-8", "replace").split("\n")
    for problem in caught.value.problems:
        assert problem.place.file == name
        assert 1 <= problem.place.line <= len(lines)
        assert 1 <= problem.place.column <= len(lines[problem.place.line - 1]) + 1


@pytest.mark.parametrize("name", FILES)
def test_nothing_reaches_the_terminal(name, monkeypatch):
    monkeypatch.chdir(ERRORS)
    with pytest.raises(ModelError) as caught:
        load(name)
    assert all(character == "\n" or character.isprintable() for character in str(caught.value))


def test_all_messages_belong_to_a_file():
    assert {path.stem for path in ERRORS.glob("*.txt")} == {Path(name).stem for name in FILES}


@pytest.mark.parametrize(
    ("path", "message"),
    [("no_such_file.yaml", "no such file"), (".", "directory"), ("a\0b", "cannot be read")],
)
def test_unreadable(path, message, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError, match=message):
        load(path)


def test_too_large(tmp_path):
    path = tmp_path / "large.yaml"
    path.write_bytes(b"#" * 5_000_001)
    with pytest.raises(ModelError, match="larger than 5 MB"):
        load(path)
