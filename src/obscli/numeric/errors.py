"""What the numerical side raises."""

from __future__ import annotations


class NotComputableError(ValueError):
    """The numerical side cannot work on this system as asked; the text says why and what to do."""


class TooManyStepsError(NotComputableError):
    """An interval that would take more steps than are made; a shorter one may do."""


class UnfitRequestError(NotComputableError):
    """What the user asked for does not fit the system: an empty interval, sizes the file does not give."""
