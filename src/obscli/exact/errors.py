"""What can go wrong in exact algebra, all of it leading to *undecided* with a reason, never to a guess."""

from __future__ import annotations


class UndecidedError(Exception):
    """A question that cannot be decided exactly (zero test, sign of a radicand, size); says why."""


class UndefinedError(Exception):
    """A coefficient that does not exist at the values in force (a denominator that is zero)."""


class JetOverflowError(Exception):
    """More derivatives of a function were needed than the field holds; build it again with more."""
