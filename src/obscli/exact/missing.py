"""Signals by which reading an expression asks for a richer field; caught by the interpreter only."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from obscli.exact.field import Generator


class MissingError(Exception):
    """The field lacks a generator."""

    def __init__(self, generator: Generator) -> None:
        super().__init__(generator.name)
        self.generator = generator


class RefineError(Exception):
    """The base of an angle or exponent is too coarse: ``atom`` needs to be taken in steps of ``step``."""

    def __init__(self, atom: str, step: Fraction) -> None:
        super().__init__(atom)
        self.atom = atom
        self.step = step
