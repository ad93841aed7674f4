"""A stationary system of the same order: x = T(t) z, where one is found.

    z = V x,   V' + V A = A_z V,   H = H_z V,   V (n, n) invertible,   T = V^{-1}

The rows of V span a closed space of forms that has the rows of H, of dimension n over the constants and of
rank n over the field. It is built from closed spaces that add as much to the rank as to the dimension: that
of the rows of H, those of single states, then those of the modes of D on the largest closed space within
functions ⊗ states. Where moving states move by coefficients that vary, half the frequencies are taken
too: axes that turn by θ show in A as 2θ.

What is found is a change of variables. That nothing is found proves that there is none only where the closure
of the rows of H is itself larger than its rank.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from obscli.exact.closure import closure
from obscli.exact.kronecker import functions_in, ordered
from obscli.exact.largest_closed import largest_closed, modes_of_rate


if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from obscli.exact.closure import Span
    from obscli.exact.closure_screen import Screen, Values
    from obscli.exact.constant_span import Forms
    from obscli.exact.exact_system import Row
    from obscli.exact.mode import Mode

#: The largest space of functions ⊗ states that is searched.
_LARGEST: Final = 150


def same_order(forms: Forms, screen: Screen) -> Span | None:
    """Return a closed space of forms that is a change of variables; None: none was found."""
    n = len(forms.A)
    for candidates in (_all_states, _states, _modes):
        chosen = _Chosen(screen, n)
        if not chosen.add(forms.H):
            return None
        for candidate in candidates(forms, screen):
            if chosen.size == n:
                break
            chosen.add(candidate)
        if chosen.size == n:
            return closure(forms, chosen.generators, chosen.closure)
    return None


class _Chosen:
    """Generators of a closed space whose dimension over the constants is its rank over the field.

    A rank at a random instant modulo a prime is not above the rank, which is not above the dimension.
    """

    def __init__(self, screen: Screen, most: int) -> None:
        self._screen, self._most = screen, most
        self.closure: dict[int, Values] = {}
        self.generators: list[Row] = []

    @property
    def size(self) -> int:
        """The dimension of the space."""
        return len(self.closure)

    def add(self, forms: Sequence[Row]) -> bool:
        """Take in what forms generate, if it adds as much to the rank as to the dimension."""
        found = self._screen.closure(forms, self.closure, dimensions=self._most)
        if found is None or self._screen.rank_over_the_field(found.values()) < len(found):
            return False
        if len(found) > self.size:
            self.generators += forms
            self.closure = found
        return True


def _all_states(forms: Forms, screen: Screen) -> Iterator[Sequence[Row]]:
    """Yield all states together: enough where nothing varies."""
    del screen
    yield [forms.state(i) for i in range(len(forms.A))]


def _states(forms: Forms, screen: Screen) -> Iterator[Sequence[Row]]:
    """Yield the states one by one."""
    del screen
    for i in range(len(forms.A)):
        yield [forms.state(i)]


def _modes(forms: Forms, screen: Screen) -> Iterator[Sequence[Row]]:
    """Yield the modes of D, long chains before the forms that these lead to, then the states."""
    functions = _functions(forms)
    if len(functions) * len(forms.A) <= _LARGEST:
        modes = [[mode] for mode in modes_of_rate(forms, largest_closed(forms, functions))]
        yield from sorted(modes, key=lambda mode: -len(screen.finite(mode)))
    yield from _states(forms, screen)


def _functions(forms: Forms) -> list[Mode]:
    """Return 1 and the functions in A and H; with those of half their frequencies, where that may help."""
    found = {forms.modes.one, *functions_in(forms)}
    if not forms.closes:
        for mode in tuple(found):
            if not any(turn % 2 for turn in mode.turns):
                halved = mode._replace(turns=tuple(turn // 2 for turn in mode.turns))
                found |= (
                    {halved._replace(sine=False), halved._replace(sine=True)} if any(mode.turns) else set()
                )
    return ordered(found)
