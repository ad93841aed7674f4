"""What the user asks of a pipeline, in words: how to change the model, which stages, which basis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias


#: Told what is being done; may be called often.
Progress: TypeAlias = Callable[[str], None]


class RequestError(ValueError):
    """A request that does not fit the model: an unknown stage, a state that is not there."""


@dataclass(frozen=True, slots=True)
class Changes:
    """Changes made to the file's system while reading it, as the texts the user gave.

    ``settings``: new nominal values; ``fix``: exact substitutions; ``outputs``: keep only these (empty: all);
    ``without``: states removed.
    """

    settings: Mapping[str, str] = field(default_factory=dict)
    fix: Mapping[str, str] = field(default_factory=dict)
    outputs: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    def data(self) -> dict[str, object]:
        """Return the changes as JSON values."""
        return {
            "set": dict(self.settings),
            "fix": dict(self.fix),
            "outputs": list(self.outputs),
            "without": list(self.without),
        }


#: The parts of an analysis that can be asked for alone.
Part: TypeAlias = Literal["analytic", "numeric", "verify", "structure"]

#: How the Gramian can be found, and the units in which its rank can be decided.
Method: TypeAlias = Literal["square-root", "lyapunov", "quadrature", "lift"]
Scaling: TypeAlias = Literal["automatic", "scale", "prior", "none"]


@dataclass(frozen=True, slots=True)
class NumericRequest:
    """How the Gramian is to be found, as the texts the user gave; None: as the file or obscli has it.

    ``start``, ``stop``, ``times``: expressions in the names of the file; ``samples``: how many instants;
    ``rtol``: relative step error; ``scaling``: units of the states in which the rank is decided.
    """

    start: str | None = None
    stop: str | None = None
    samples: int | None = None
    times: tuple[str, ...] = ()
    method: Method = "square-root"
    rtol: float | None = None
    scaling: Scaling | None = None


@dataclass(frozen=True, slots=True)
class AnalyzeRequest:
    """How to analyse: stages (empty: all), basis (a path: rows preferred), pivots, critical search.

    ``only``: one part alone; ``numeric``: the options of the numerical side; ``curves``: guess the forms of
    the coefficients also where the numerical side is not alone; ``relations``: find what outputs are made of;
    ``cross_check``: solve the Riccati equation from two priors; ``dual``: what the inputs reach instead;
    ``frozen_at``: an instant at which A and H are taken as constant, in the names of the file; ``certify``:
    prove the rank of the Gramian at instants in ball arithmetic; ``segments``: only the segments of the file.
    """

    stages: tuple[str, ...] = ()
    basis: Literal["echelon", "sparse"] | Path = "echelon"
    pivot_order: tuple[str, ...] = ()
    critical: bool = True
    only: Part | None = None
    numeric: NumericRequest = NumericRequest()
    curves: bool = False
    relations: bool = False
    cross_check: bool = False
    dual: bool = False
    frozen_at: str | None = None
    certify: bool = False
    segments: bool = False


#: The parts of a calibration that can be asked for alone.
CalibrationPart: TypeAlias = Literal["analytic"]


@dataclass(frozen=True, slots=True)
class CalibrateRequest:
    """Which runs (empty: all) to analyse and how: search for critical values, one part only, the Gramian."""

    runs: tuple[str, ...] = ()
    critical: bool = True
    only: CalibrationPart | None = None
    numeric: NumericRequest = NumericRequest()


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """Which candidates (empty: all) to choose from; the options of the Gramians that check the choice.

    ``segments``: find orders of the file's segments instead.
    """

    runs: tuple[str, ...] = ()
    numeric: NumericRequest = NumericRequest()
    segments: bool = False


#: What a system can be transformed to.
Target: TypeAlias = Literal["observable", "kalman", "stationary", "drop"]


@dataclass(frozen=True, slots=True)
class TransformRequest:
    """What to transform to, which stages (empty: all), the form of the observable combinations, pivots.

    ``one``: the model is to be written, so that there has to be one stage.
    """

    to: Target = "observable"
    stages: tuple[str, ...] = ()
    basis: Literal["echelon", "sparse"] = "echelon"
    pivot_order: tuple[str, ...] = ()
    one: bool = False


def silent(_: str) -> None:
    """Progress that nobody watches."""


#: The units of the states in which measures are taken: as given, the prior's deviations, `scale`.
MeasureScaling: TypeAlias = Literal["none", "prior", "scale"]


@dataclass(frozen=True, slots=True)
class MeasuresRequest:
    """Which measures (empty: all but habits), in which stages, when, in which units.

    ``at``: instants as expressions, empty: the end of the interval; ``options``: as text,
    ``{"least-squares.dt": "1"}``; ``thresholds``: a number by key of a measure; ``step``: seconds between
    samples; ``curves``: find what the figures show; ``segments``: only the segments, at their end.
    """

    stages: tuple[str, ...] = ()
    at: tuple[str, ...] = ()
    select: tuple[str, ...] = ()
    options: Mapping[str, str] = field(default_factory=dict)
    thresholds: Mapping[str, str] = field(default_factory=dict)
    scaling: MeasureScaling = "none"
    numeric: NumericRequest = NumericRequest()
    step: float | None = None
    curves: bool = False
    segments: bool = False


#: The parts of an explanation that can be asked for alone.
WhyPart: TypeAlias = Literal["analytic"]


#: What the matrix of a window is made of, and how its singular values are weighed.
Stack: TypeAlias = Literal["discrete", "continuous"]
Weights: TypeAlias = Literal["squared", "abs"]


@dataclass(frozen=True, slots=True)
class WindowsRequest:
    """Which windows to look at: stages (empty: all), their length, how they are weighed.

    ``length``: of a window; ``step``: between windows, and between samples where the file does not say;
    ``stack``: samples of the outputs, or derivatives at the start; ``frozen``: A and H keep the values of the
    start; ``weights``: of the singular values; ``scaling``: None: the prior's, else the file's sizes, else
    none; ``kept``: so many windows at the most are reported; ``advice``: find which motion the states need;
    ``show``: states, vectors and quantities that tables and figures are about (empty: all).
    """

    length: float
    step: float | None = None
    stages: tuple[str, ...] = ()
    stack: Stack = "discrete"
    frozen: bool = True
    weights: Weights = "squared"
    scaling: MeasureScaling | None = None
    numeric: NumericRequest = NumericRequest()
    kept: int = 20_000
    advice: bool = False
    show: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class WhyRequest:
    """What to explain (a state, a vector, a quantity, a combination), in which stages, which part."""

    target: str
    stages: tuple[str, ...] = ()
    only: WhyPart | None = None
    numeric: NumericRequest = NumericRequest()


@dataclass(frozen=True, slots=True)
class SimulateRequest:
    """What to simulate: stages (empty: all), the interval (in ``numeric``), samples, random runs.

    ``step``: time between samples of outputs that have no rate of their own, None: as in the file;
    ``recorded``: instants that the histories keep; ``runs``: random runs, 0: none; ``fraction``: of the prior
    below which a deviation counts as small where the file requires nothing; ``segments``: only the segments;
    ``initial``: states with an error at the start, an expression each; ``feedback``: None: output correction,
    empty: all estimates are fed back, else those of states and vectors named, one ``sigma<c`` among them.
    """

    stages: tuple[str, ...] = ()
    step: float | None = None
    recorded: int = 500
    runs: int = 0
    seed: int = 0
    fraction: float = 0.1
    numeric: NumericRequest = NumericRequest()
    segments: bool = False
    initial: tuple[tuple[str, str], ...] = ()
    feedback: tuple[str, ...] | None = None
