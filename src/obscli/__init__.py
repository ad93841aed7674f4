"""obscli: which linear combinations of the states of x' = A(t)x, y = H(t)x can be estimated, with proof.

Notation, in code and docstrings (words are used on the command line, in YAML and in JSON):

=========  ==========  ================================================================================
letter     shape       meaning
=========  ==========  ================================================================================
x          (n,)        states; x' = A x + B u + G w
y          (m,)        outputs; y = H x + v
A          (n, n)      dynamics, real-analytic in t
H          (m, n)      measurements, real-analytic in t
B, G       (n, p|q)    inputs u and disturbances w: they do not enter observability
L_k        (m, n)      rows of the observability matrix: L_0 = H, L_k = L_{k-1}' + L_{k-1} A
L          (m n, n)    the L_k on top of each other; order: the k at which their rank saturates
r          ()          generic rank of L: of parameters, functions and almost every t
xi, s      (n,), ()    observable covector (row of the span of L), its combination s(t) = xi(t) x(t)
N          (n, n-r)    unobservable directions (columns): H N = 0, N' - A N in span N
Phi        (n, n)      transition: dPhi/dtau = A(tau) Phi, Phi(t, t) = I
W          (n, n)      Gramian: dW/dt = -A^T W - W A + H^T H, W(t0, t0) = 0
P          (n, n)      covariance of the estimation error
Q, R       (n, n) …    spectral densities of w and v
K          (n, m)      filter gain
chi        ()          indicator of an analytic result against W: max |xi . eta| over ker W, normalised
=========  ==========  ================================================================================

A combination is *constant* where xi' + xi A = 0. A state is *observable* where it is itself a combination,
*coupled* where it enters one, *unobservable* where it enters none.

Public interface: ``load``, ``analyze``, ``verify``, ``calibrate``, ``plan``, ``transform``,
``why``, ``windows``, ``ModelError``; see ``obscli.api``.

References
----------
V. M. Morozov, F. Yu. Baklanov, "Practical methods to investigate observability of linear time-varying
systems", Fundam. Prikl. Mat. 22:2 (2018) 221-236.
L. M. Silverman, H. E. Meadows, "Controllability and observability in time-variable linear systems",
SIAM J. Control 5:1 (1967) 64-73.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.core.version import VERSION


if TYPE_CHECKING:
    from obscli.api import (
        AnalyzeReport,
        CalibrateReport,
        MeasuresReport,
        PlanReport,
        SimulateReport,
        TransformReport,
        VerifyReport,
        WhyReport,
        WindowsReport,
        analyze,
        calibrate,
        load,
        measure,
        plan,
        simulate,
        transform,
        verify,
        why,
        windows,
    )
    from obscli.core.place import ModelError
    from obscli.pipelines.request import (
        AnalyzeRequest,
        CalibrateRequest,
        Changes,
        MeasuresRequest,
        PlanRequest,
        SimulateRequest,
        TransformRequest,
        WhyRequest,
        WindowsRequest,
    )


__version__ = VERSION

__all__ = [
    "AnalyzeReport",
    "AnalyzeRequest",
    "CalibrateReport",
    "CalibrateRequest",
    "Changes",
    "MeasuresReport",
    "MeasuresRequest",
    "ModelError",
    "PlanReport",
    "PlanRequest",
    "SimulateReport",
    "SimulateRequest",
    "TransformReport",
    "TransformRequest",
    "VerifyReport",
    "WhyReport",
    "WhyRequest",
    "WindowsReport",
    "WindowsRequest",
    "__version__",
    "analyze",
    "calibrate",
    "load",
    "measure",
    "plan",
    "simulate",
    "transform",
    "verify",
    "why",
    "windows",
]

#: Where each public name lives; imported when first used, so that ``import obscli`` costs nothing.
_HOMES = {
    "AnalyzeReport": "obscli.api",
    "AnalyzeRequest": "obscli.pipelines.request",
    "CalibrateReport": "obscli.api",
    "CalibrateRequest": "obscli.pipelines.request",
    "Changes": "obscli.pipelines.request",
    "MeasuresReport": "obscli.api",
    "MeasuresRequest": "obscli.pipelines.request",
    "ModelError": "obscli.core.place",
    "PlanReport": "obscli.api",
    "PlanRequest": "obscli.pipelines.request",
    "SimulateReport": "obscli.api",
    "SimulateRequest": "obscli.pipelines.request",
    "TransformReport": "obscli.api",
    "TransformRequest": "obscli.pipelines.request",
    "VerifyReport": "obscli.api",
    "WhyReport": "obscli.api",
    "WhyRequest": "obscli.pipelines.request",
    "WindowsReport": "obscli.api",
    "WindowsRequest": "obscli.pipelines.request",
    "analyze": "obscli.api",
    "calibrate": "obscli.api",
    "load": "obscli.api",
    "measure": "obscli.api",
    "plan": "obscli.api",
    "simulate": "obscli.api",
    "transform": "obscli.api",
    "verify": "obscli.api",
    "why": "obscli.api",
    "windows": "obscli.api",
}


def __getattr__(name: str) -> object:
    """Import a public name on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module 'obscli' has no attribute {name!r}")
    import importlib  # noqa: PLC0415 - light, and not needed by the command line

    value: object = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
