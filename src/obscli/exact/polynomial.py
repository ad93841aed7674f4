"""The polynomials underneath the field: multivariate over Z, from FLINT."""

from __future__ import annotations

from typing import TypeAlias

from flint import fmpz_mpoly


Polynomial: TypeAlias = fmpz_mpoly
