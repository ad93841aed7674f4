"""A hand-built finding that has something in every section of the report."""

from fractions import Fraction
from pathlib import Path

import pytest

from obscli.core.check import Change, CheckResult, Counterexample, Indicator, Trajectories
from obscli.core.place import Place
from obscli.core.verification import CombinationCheck, Point, Verification
from obscli.exact.finding import (
    Analysis,
    AtValues,
    Certificate,
    Combination,
    CriticalSearch,
    CriticalValue,
    LowerBound,
    Neglect,
    QuantityVerdict,
    Undecided,
    UpperBound,
)
from obscli.model.expression import ONE, ZERO, Apply, Symbol, add, divide, multiply, negate, number, power
from obscli.model.system import Matrix, Model, Output, Parameter, State, System
from obscli.numeric.finding import (
    CoefficientCurve,
    EchelonFinding,
    Guess,
    NotComputed,
    NumericFinding,
    NumericPoint,
)
from obscli.pipelines.analyze import AnalyzeReport
from obscli.pipelines.request import Changes
from obscli.pipelines.stage_result import StageChecks, StageResult
from obscli.pipelines.verify_report import VerifyReport


HERE = Place("sample.yaml", 1, 1)
STATES = ("psi1", "psi2", "psi3", "b_g1", "b_a1", "M_g11")
MINUS = number(-1)
omega, omega_ie, phi, g, t = (Symbol(name) for name in ("omega", "omega_ie", "phi", "g", "t"))


def make_system(
    stage="stage_1", states=STATES, outputs=("y1", "y2"), parameters=("omega", "omega_ie", "phi", "g")
):
    n, m = len(states), len(outputs)
    return System(
        stage=stage,
        time="t",
        parameters=tuple(Parameter(name, HERE) for name in parameters),
        functions=(),
        invariants=(),
        states=tuple(State(name, HERE) for name in states),
        outputs=tuple(Output(name, HERE) for name in outputs),
        A=Matrix(n, n, {}),
        H=Matrix(m, n, {}),
    )


def make_certificate():
    return Certificate(
        model="0" * 16,
        rank=3,
        order=1,
        lower=LowerBound(
            point={"t": "3/7", "omega": "2", "omega_ie": "5", "phi": "1/3", "g": "7"},
            rows=(("y1", 0), ("y2", 0), ("y2", 1)),
            columns=("psi1", "psi2", "psi3"),
            midpoint="-33.0712",
            radius="1.2e-30",
            precision=128,
        ),
        upper=UpperBound(
            kernel=(
                {"psi3": ONE, "b_g1": multiply(omega_ie, Apply("cos", phi))},
                {"M_g11": ONE, "b_g1": negate(omega)},
            ),
            multiplier=((ZERO, ZERO), (ZERO, ZERO)),
            delay={"psi3": ONE},
        ),
        assumes=(),
    )


def make_analysis(system=None, **changes):
    system = system or make_system()
    rate = multiply(omega_ie, Apply("cos", phi))
    second = {"psi2": g, "b_a1": MINUS}
    long = {
        "psi3": rate,
        "b_g1": MINUS,
        "b_a1": negate(divide(multiply(omega_ie, Apply("sin", phi)), g)),
        "M_g11": negate(multiply(add(omega, power(rate, 2)), Apply("cos", multiply(omega, t)))),
    }
    defaults = {
        "system": system,
        "rank": 3,
        "order": 1,
        "combinations": (
            Combination({"psi1": ONE}, constant=False, output="y1", order=0),
            Combination(second, constant=False, output="y2", order=0),
            Combination(long, constant=True, output="y2", order=1),
        ),
        "unobservable": make_certificate().upper.kernel,
        "states": {
            "psi1": "observable",
            "psi2": "coupled",
            "psi3": "coupled",
            "b_g1": "coupled",
            "b_a1": "coupled",
            "M_g11": "unobservable",
        },
        "groups": (("psi2", "b_a1"), ("psi3", "b_g1")),
        "quantities": (
            QuantityVerdict("heading", {"psi3": MINUS}, "coupled", ("b_g1", "psi3")),
            QuantityVerdict("tilt", {"psi1": number(Fraction(1, 2))}, "observable", ()),
        ),
        "certificate": make_certificate(),
        "at_values": AtValues(2, ("omega = omega_ie*cos(phi)",)),
        "frozen_rank": 2,
        "critical": CriticalSearch(
            values=(
                CriticalValue("omega = 0", "confirmed", 2, (second, long)),
                CriticalValue("omega_ie = 0", "excluded", 2, (), "omega_ie is assumed positive"),
            ),
            complete=True,
            not_searched=("codimension two and more",),
            instants=("at t = 0 the rows of L lose one rank for an instant",),
        ),
        "varying": ("cos of omega*t",),
        "notes": ("an invariant that is not stated would lower the rank",),
        "advice": ("Estimate the three combinations above.", "To separate b_a1 from psi2, turn the table."),
        "neglect": (Neglect("omega_ie = 0", 3, 2, (second,), ()),),
    }
    return Analysis(**(defaults | changes))


def make_model(systems, name="sample", title="A sample of every section"):
    return Model(name=name, file=Path("sample.yaml"), systems=tuple(systems), title=title)


def report_of(*findings, **names):
    model = make_model([finding.system for finding in findings], **names)
    return AnalyzeReport(
        tuple(StageResult(model, finding.system, finding) for finding in findings), Changes()
    )


def make_numeric(system, **changes):
    """Six states at three instants, the first one undecided."""
    points = tuple(
        NumericPoint(
            t=10.0 * k,
            start=0.0,
            rank=2 + (k > 1),
            decided=k > 1,
            gap=40.0 if k == 1 else 2.5e9,
            tolerance=6.1e-15,
            singular_values=(2.0, 1.0, 10.0 ** (k - 6), 2e-16, 1e-16, 0.0),
            basis=None,
        )
        for k in (1, 2, 3)
    )
    defaults = {
        "system": system, "method": "square-root", "rtol": 1e-14, "scaling": "automatic", "start": 0.0,
        "default": True, "points": points, "rank": 3, "sampled": ("f_E", "f_N"), "window": 2.0,
        "states": {"psi1": "observable", "psi2": "coupled", "psi3": "coupled", "b_g1": "coupled",
                   "b_a1": "coupled", "M_g11": "unobservable"},
        "groups": (("psi2", "b_a1"), ("psi3", "b_g1")),
    }  # fmt: skip
    return NumericFinding(**(defaults | changes))


def make_verification(*, wrong=False):
    """Three instants; where wrong, the second combination leaks."""
    points = tuple(
        Point(t=10.0 * k, r=3, q=4 - (k > 1), chi=0.094 if wrong else 10.0**-k, bound=2.0 * 10.0**-k,
              gap=None if k == 1 else 2.5e9, conclusive=k > 1, agrees=k > 1 and not wrong, refutes=k > 1 and wrong)
        for k in (1, 2, 3)
    )  # fmt: skip
    combinations = (
        CombinationCheck("psi1", 1e-12, 2e-12, holds=True),
        CombinationCheck(
            "g*psi2", 0.094, 1e-12, holds=not wrong, correction="g*psi2 - b_a1" if wrong else ""
        ),
    )
    verdict = "contradicted" if wrong else "verified"
    return Verification(verdict, "χ speaks against it", "The diagnosis in words.", 6, points, combinations)


def make_basis():
    instants = (10.0, 20.0, 30.0)

    def curve(pivot, free, guess, standing):
        return CoefficientCurve(
            pivot, free, instants, (-0.1, -0.2, -0.1), (1e-9,) * 3, guess, None, standing=standing
        )

    named = Guess(negate(divide(ONE, g)), 3e-14, 2e-14)
    digits = Guess(
        multiply(number(Fraction("0.10003293")), Apply("cos", multiply(omega, t))), 3e-7, 2e-8, in_digits=True
    )
    return EchelonFinding(
        ("psi1", "psi2", "psi3"),
        (
            curve("psi2", "b_a1", named, "proved"),
            curve("psi2", "M_g11", digits, "guess"),
            curve("psi3", "b_g1", Guess(None, reason="no form of the dictionary fits"), "not identified"),
        ),
    )


@pytest.fixture
def compared():
    """Four stages held against the Gramian: all sections; the Gramian alone; contradicted; not computed."""
    systems = [make_system(f"stage_{k}") for k in (1, 2, 3, 4)]
    model = make_model(systems)
    rest = {"critical": None, "neglect": (), "advice": (), "notes": (), "certificate": None, "quantities": ()}
    both = make_analysis(systems[0], **rest)
    return AnalyzeReport(
        (
            StageResult(model, systems[0], both, make_numeric(systems[0]), make_verification(), make_basis(), "verify"),
            StageResult(model, systems[1], None, make_numeric(systems[1], window=None), None, make_basis(), "numeric"),
            StageResult(model, systems[2], both, make_numeric(systems[2], sampled=()), make_verification(wrong=True),
                        None, "verify"),
            StageResult(model, systems[3], None, NotComputed("parameter without a value: a"), None, None, "numeric"),
        ),
        Changes(),
    )  # fmt: skip


@pytest.fixture
def checked():
    """Checks of every kind, with all that can be said of a false one."""
    system = make_system()
    trajectories = Trajectories((0.0, 5.0), {"b_g1": (0.1, 0.1)}, (0.1, 0.1), 3e-16)
    example = Counterexample({"b_g1": "omega", "M_g12": "-1"}, "omega", True, trajectories)
    changes = (
        Change("b_g1", "omega*M_g12", "b_g1 + omega*M_g12", "lacks + omega*M_g12"),
        Change("b_g1", "-b_a1", "b_g1 - b_a1", "lacks - b_a1"),
    )
    place = Place("claims.yaml", 4, 7)
    return VerifyReport(
        (
            StageChecks(
                make_model([system]), system,
                (
                    CheckResult("rank 3", "holds", "proved exactly", place, Indicator(2, 3)),
                    CheckResult("these rows are a basis", "holds", "proved", place, Indicator(2, 2, 3e-9, 2e-8),
                                transformation=(("1", "0"), ("omega", "1"))),
                    CheckResult("b_g1 is observable", "fails", "not observable", place, Indicator(0, 2, 0.094, 1e-9),
                                changes, example),
                    CheckResult("these 2 combinations are a complete basis", "fails", "one row is wrong", place,
                                verification=make_verification(wrong=True)),
                    CheckResult("psi1 is observable", "undecided", "whether a is zero", place),
                ),
                make_verification(),
            ),
        )
    )  # fmt: skip


@pytest.fixture
def report():
    """Two stages, the second undecided."""
    second = make_system("stage_2")
    return report_of(make_analysis(), Undecided(second, "sample.yaml:7:3: whether log(2) - a is zero"))


@pytest.fixture
def hostile():
    """Names and texts of a stranger's file: escape codes, markup of every format, bidi override."""
    evil = "a\x1b[31m|$`*_<b>\\end{document}%\u202e[bold]{}&#^~\nx"
    system = make_system(evil, states=(evil, "b"), outputs=(evil,), parameters=(evil,))
    analysis = make_analysis(
        system,
        combinations=(Combination({"b": ONE}, constant=True, output=evil, order=0),),
        unobservable=(),
        certificate=None,
        states={evil: "unobservable", "b": "observable"},
        groups=((evil, "b"),),
        quantities=(QuantityVerdict(evil, {"b": ONE}, "coupled", (evil,)),),
        critical=CriticalSearch((CriticalValue(evil, "confirmed", 0, ()),), False, (evil,), (evil,)),
        varying=(evil,),
        undecided=(evil,),
        notes=(evil,),
        advice=(evil,),
        neglect=(),
    )
    return report_of(analysis, name=evil, title=evil)
