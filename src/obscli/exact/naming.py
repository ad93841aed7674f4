"""Names of generators by what they stand for, stable when the field is built again with more of them."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.reader import Reader


_LONGEST = 300


def stable_name(it: Reader, polynomial: Polynomial) -> str:
    """Write a polynomial in the names of the generators, terms sorted."""
    names = [generator.name for generator in it.field.generators]
    terms = [
        f"{coefficient}" + "".join(f"*{names[k]}^{e}" for k, e in enumerate(exponents) if e)
        for exponents, coefficient in polynomial.terms()
    ]
    text = "+".join(sorted(terms))
    # names of nested functions contain each other and would double in length with every level
    return text if len(text) <= _LONGEST else hashlib.sha256(text.encode()).hexdigest()
