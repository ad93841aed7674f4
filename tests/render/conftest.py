"""A hand-built finding that has something in every section of the report."""

from fractions import Fraction
from pathlib import Path

import pytest

from obscli.core.place import Place
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
from obscli.pipelines.analyze import AnalyzeReport
from obscli.pipelines.request import Changes
from obscli.pipelines.stage_result import StageResult


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
