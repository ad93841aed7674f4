"""The method of unobservable states, automated: y_i(t) = Σ_j f_j(t) d_ijᵀ x0, term by term.

Of a time-invariant system, with μ the least polynomial that annihilates the rows of H, d its degree, and
f_0 … f_{d−1} a basis of the solutions of μ(d/dt) f = 0:

    H e^{At} = Σ_j f_j(t) D_j      exactly if      H A^k = Σ_j f_j^(k)(0) D_j,   k < d

(both sides are annihilated by μ(d/dt) and begin with the same d derivatives). The matrix of the f_j^(k)(0)
is invertible and its entries are in the field, so the D_j are found exactly. Their rows span those of the
observability matrix: the method agrees with the rank condition, which is checked all the same.

References
----------
V. I. Kortunov, G. A. Proskura (2006), (4)-(7).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.annihilator import annihilator
from obscli.exact.column_relations import relations_by_columns
from obscli.exact.errors import JetOverflowError, UndecidedError
from obscli.exact.exact_system import more_jets
from obscli.exact.fundamental import fundamental_system, inverse_at_zero
from obscli.exact.prove import Proof, prove_read
from obscli.exact.relation_terms import Term, related
from obscli.exact.relations_finding import Relations
from obscli.exact.rows import field_row
from obscli.exact.series_relations import series_relations
from obscli.exact.spectrum import factors


if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element, Field
    from obscli.exact.fundamental import Fundamental, FundamentalSystem


def relations_of(proof: Proof) -> Relations:
    """Return the relations of a system whose rank is proved.

    Raises
    ------
    UndecidedError : the coefficients grow too large, or the relations do not agree with the rank; for a
        discrete-time system, whose outputs are no functions of time
    """
    if proof.exact.system.discrete:
        raise UndecidedError("the outputs of a discrete-time system are sequences")
    while True:
        try:
            return series_relations(proof) if proof.exact.varies else _exact_relations(proof)
        except JetOverflowError:  # the blocks themselves need more derivatives than their reduced rows
            proof = prove_read(more_jets(proof.exact), range(proof.exact.n), ())


def _exact_relations(proof: Proof) -> Relations:
    exact = proof.exact
    field = exact.field
    basis, rows = _all_at_once(proof)
    kernel = [field_row(field, column) for column in proof.kernel.columns.values()]
    given = _terms(proof, basis.functions, rows)
    terms = related(field, exact.system.state_names, proof.restorer, given, kernel, proof.rank)
    return Relations(
        exact=True,
        relations=terms.relations,
        situations=terms.situations,
        canonical=basis.canonical,
        notes=basis.notes,
    )


def _all_at_once(proof: Proof) -> tuple[FundamentalSystem, Sequence[Sequence[Row]]]:
    """Return the functions and, for each, the rows of D_j = Σ_k X_jk H A^k, X the inverse of the f_j^(k)(0).

    Where the coefficients of all columns together are too large, the columns are taken one by one.
    """
    try:
        found = annihilator(proof.exact)
        basis, weights = _basis(proof, found.coefficients)
        return basis, [_combined(proof.exact.field, weight, found.blocks) for weight in weights]
    except UndecidedError:
        return relations_by_columns(proof)


def _basis(proof: Proof, coefficients: Sequence[Element]) -> tuple[FundamentalSystem, list[Row]]:
    """Return functions that μ(d/dt) annihilates, and the inverse of the matrix of their derivatives at 0.

    Factors found formally may have a root in common; the functions are dependent then.
    """
    field = proof.exact.field
    for formally in (True, False):
        basis = fundamental_system(proof, factors(field, coefficients, formally=formally))
        weights = inverse_at_zero(field, basis.functions)
        if len(weights) == len(basis.functions):
            return basis, weights
    raise UndecidedError("the functions of time that the outputs consist of were not told apart")


def _combined(field: Field, weights: Row, blocks: Sequence[Sequence[Row]]) -> list[Row]:
    """Return Σ_k X_k H A^k by rows."""
    rows: list[Row] = []
    for i in range(len(blocks[0])):
        total: dict[int, Element] = {}
        for k, weight in weights.items():
            for j, entry in blocks[k][i].items():
                total[j] = total.get(j, field.zero) + weight * entry
        rows.append({j: entry for j, entry in total.items() if entry})
    return rows


def _terms(proof: Proof, functions: Sequence[Fundamental], rows: Sequence[Sequence[Row]]) -> Iterator[Term]:
    outputs = proof.exact.system.outputs
    for function, D in zip(functions, rows, strict=True):
        for output, row in zip(outputs, D, strict=True):
            yield Term(function.expression, output.name, row)
