"""What is asked of the numerical side: which instants, which method, how accurate, in which units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from obscli.numeric.constant_form import ConstantForm
from obscli.numeric.gramian import Method
from obscli.numeric.horizon import Wanted
from obscli.numeric.scaling import Scaling


#: The step error each method is asked for where the user says nothing.
STEP_ERROR: Final[dict[Method, float]] = {
    "square-root": 1e-14,
    "quadrature": 1e-14,
    "lyapunov": 1e-10,
    "lift": 0.0,
}


@dataclass(frozen=True, slots=True)
class Effort:
    """How accurate one Gramian has to be, and at what cost: relative step error, and steps at the most."""

    rtol: float
    most_steps: int


@dataclass(frozen=True, slots=True, eq=False)
class Settings:
    """The numerical side's options.

    ``rtol``: relative step error, None: the method's own; ``scaling``: units in which the rank is decided,
    None: the file's sizes where it gives them for every state, else automatic; ``lift``: a stationary system
    with the same outputs, for the method of that name.
    """

    wanted: Wanted = field(default_factory=Wanted)
    method: Method = "square-root"
    rtol: float | None = None
    scaling: Scaling | None = None
    lift: ConstantForm | None = None

    @property
    def step_error(self) -> float:
        """The relative step error in force."""
        return STEP_ERROR[self.method] if self.rtol is None else self.rtol
