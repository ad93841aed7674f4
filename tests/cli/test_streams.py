"""What goes where: progress to stderr and only when it takes long, colour to terminals that want it."""

import errno
import io
import sys
import time

import pytest

from obscli.cli import output, progress
from obscli.cli.boundary import complain
from obscli.cli.errors import CommandError
from obscli.cli.progress import ProgressLine


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self):
        return True


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.01)
    monkeypatch.setattr(progress, "BEAT", 0.01)


def wait_for(stream, text):
    deadline = time.monotonic() + 5
    while text not in stream.getvalue() and time.monotonic() < deadline:
        time.sleep(0.01)


def test_quick_work_shows_no_progress(capsys):
    with ProgressLine() as line:
        line("critical values")

    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("impatient")
def test_each_long_step_is_one_line(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)

    with ProgressLine() as line:
        line("first\x1b[31m")
        wait_for(stream, "first")
        line("second")
        wait_for(stream, "second")

    assert stream.getvalue() == "obscli: first\\x1b[31m\nobscli: second\n"


@pytest.mark.usefixtures("impatient")
def test_a_terminal_is_left_clean(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr("sys.stderr", stream)

    with ProgressLine() as line:
        line("long step")
        wait_for(stream, "long step")

    assert stream.getvalue().endswith("\r\x1b[K")


@pytest.mark.parametrize(
    ("variables", "expected"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)]
)
def test_colour_where_wanted(monkeypatch, variables, expected):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.stdout", Terminal())

    assert output._surface(None, details=False).colour is expected


def test_no_colour_in_files_and_pipes(tmp_path):
    assert not output._surface(tmp_path / "report.txt", details=False).colour
    assert not output._surface(None, details=False).colour


def test_signs_for_an_output_without_unicode(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)

    output.write("● psi ≥ φ\n", None)

    assert stream.buffer.getvalue() == b"* psi >= \\u03c6\n"


def test_a_full_disk_is_no_internal_error(monkeypatch):
    class Full(io.StringIO):
        encoding = "utf-8"

        def flush(self):
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("sys.stdout", Full())
    with pytest.raises(CommandError, match="standard output cannot be written: No space left"):
        output.write("text", None)
    sys.stdout.close()


def test_complaints_cannot_control_the_terminal(capsys):
    complain("line\n\x1b[2J\u202e")

    assert capsys.readouterr().err == "line\n\\x1b[2J\\u202e\n"
