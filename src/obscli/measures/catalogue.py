"""All measures, in the order of tables: register a new one here."""

from __future__ import annotations

from typing import Final

from obscli.measures.column_norm import COLUMN_NORM
from obscli.measures.conventional_singular_value import CONVENTIONAL_SINGULAR_VALUE
from obscli.measures.covariance_reduction import COVARIANCE_REDUCTION
from obscli.measures.cramer_rao import CRAMER_RAO
from obscli.measures.determinant import DETERMINANT
from obscli.measures.deterministic import DETERMINISTIC
from obscli.measures.equivalent_singular_value import EQUIVALENT_SINGULAR_VALUE
from obscli.measures.gramian_singular_values import GRAMIAN_SINGULAR_VALUES
from obscli.measures.least_squares import LEAST_SQUARES
from obscli.measures.measure import Measure
from obscli.measures.modal import MODAL
from obscli.measures.normalised_covariance import NORMALISED_COVARIANCE
from obscli.measures.pseudo_inverse import PSEUDO_INVERSE
from obscli.measures.singular_values import SINGULAR_VALUES
from obscli.measures.standard_deviation import STANDARD_DEVIATION
from obscli.measures.stochastic import STOCHASTIC


MEASURES: Final[tuple[Measure, ...]] = (
    DETERMINISTIC,
    STOCHASTIC,
    LEAST_SQUARES,
    PSEUDO_INVERSE,
    EQUIVALENT_SINGULAR_VALUE,
    CONVENTIONAL_SINGULAR_VALUE,
    COLUMN_NORM,
    COVARIANCE_REDUCTION,
    STANDARD_DEVIATION,
    CRAMER_RAO,
    DETERMINANT,
    SINGULAR_VALUES,
    GRAMIAN_SINGULAR_VALUES,
    NORMALISED_COVARIANCE,
    MODAL,
)

BY_KEY: Final = {one.key: one for one in MEASURES}
