"""The dual system, whose observability is the controllability of the one it is made of.

    x' = −Aᵀ x,  y = Bᵀ x        (Aᵀ where A, B and H are constant: the same rows up to signs)

Its observability matrix is the reachability matrix of (A, B), transposed, the blocks up to signs:

    L_k = (−1)^k P_kᵀ,    P_0 = B,  P_{k+1} = A P_k − P_k'

so its observable combinations are the directions that the inputs reach, and its unobservable directions are
the combinations of the states that no input moves. With Aᵀ in place of −Aᵀ these go on by themselves as
the hidden part of the dual does, with the same eigenvalues: what is detectable of the dual is stabilizable.

References
----------
R. E. Kalman, On the general theory of control systems (1960); L. Weiss, R. E. Kalman (1965) for A(t), B(t).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from obscli.core.place import Place
from obscli.model.acting import Inputs, inputs_of
from obscli.model.expression import Expression, negate, power, symbols
from obscli.model.system import Matrix, Output, State, System


def dual(system: System) -> System:
    """Return the dual of a system by its inputs, or by its disturbances where it has no inputs.

    States, parameters, functions and interval stay; the inputs are outputs, and the outputs inputs. What is
    said about the original states (quantities, claims, noise, prior) is left out.

    Raises
    ------
    ValueError : the system has neither inputs nor disturbances
    """
    acting = _acting(system)
    back = system.dual if system.dual is not None else "B"
    seen = _transposed(system.H)
    outputs = tuple(output.name for output in system.outputs)
    return replace(
        system,
        A=_transposed(system.A, None if is_constant(system) else negate),
        H=_transposed(acting.matrix),
        outputs=tuple(_output(system, acting.matrix, j, name) for j, name in enumerate(acting.names)),
        B=seen if back == "B" else None,
        inputs=outputs if back == "B" else (),
        G=seen if back == "G" else None,
        disturbances=outputs if back == "G" else (),
        states=tuple(_state(state) for state in system.states),
        quantities=(),
        claims=(),
        noise=None,
        prior={},
        dual=None if system.dual is not None else acting.by,
    )


def is_constant(system: System) -> bool:
    """Whether nothing in A, H and the matrix of inputs depends on time or a function, as it is written."""
    moving = {system.time, *(function.name for function in system.functions)}
    matrices = (system.A, system.H, _acting(system).matrix)
    entries = (entry for matrix in matrices for entry in matrix.entries.values())
    return not moving & symbols(*entries)


def _acting(system: System) -> Inputs:
    """Return by what the system is to be reached: B, else G."""
    inputs = inputs_of(system)
    if inputs is None:
        raise ValueError("neither inputs nor disturbances")
    return inputs


def _transposed(matrix: Matrix, change: Callable[[Expression], Expression] | None = None) -> Matrix:
    entries = {(j, i): change(e) if change else e for (i, j), e in matrix.entries.items()}
    places = {(j, i): place for (i, j), place in matrix.places.items()}
    return Matrix(matrix.columns, matrix.rows, entries, places)


def _output(system: System, acting: Matrix, column: int, name: str) -> Output:
    places = [place for (_, j), place in acting.places.items() if j == column]
    place: Place = places[0] if places else system.states[0].place
    return Output(name, place)


def _state(state: State) -> State:
    """Return a state of the dual: it is measured against one of the original, so its scale is inverse."""
    return replace(state, unit="", scale=None if state.scale is None else power(state.scale, -1))
