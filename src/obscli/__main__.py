"""``python -m obscli``."""

from __future__ import annotations

from obscli.cli import run


if __name__ == "__main__":
    run()
