"""How far a plan looks, for those who look and those who report."""

from __future__ import annotations

from typing import Final


#: Runs of a plan that needs more than the smallest set.
MOST_ADDED: Final = 60

#: Candidates that are varied to find out what would determine the rest.
MOST_VARIED: Final = 6
