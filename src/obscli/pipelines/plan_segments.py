"""The work of ``obscli plan --segments``: which manoeuvres in which order show most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from obscli.core.number import json_number
from obscli.exact.ball import OutsideDomainError, without_value
from obscli.exact.ball_transition import TooManyBallStepsError
from obscli.experiment.segment_orders import Order, Orders, segment_orders
from obscli.model.system import Model
from obscli.pipelines.request import Progress, RequestError


@dataclass(frozen=True, slots=True, eq=False)
class SegmentPlan:
    """The orders found for the segments of a model with n states."""

    model: Model
    n: int
    found: Orders

    @property
    def title(self) -> str:
        """The name of the model, and what of it this is."""
        return f"{self.model.name} · orders of segments"


def segment_plan(model: Model, progress: Progress) -> SegmentPlan:
    """Return the shortest orders of the segments of a model that show as much as the file's own.

    Raises
    ------
    RequestError
        where there are no segments, some have jumps, or one cannot be followed
    """
    segments = model.segments
    if segments is None:
        raise RequestError(f"{model.file}: there are no `segments`")
    jumps = [one.name for one in segments.parts if one.jump is not None]
    if jumps:
        raise RequestError(
            f"{model.file}: the jump after {jumps[0]} is one between two segments in this order; to plan "
            "other orders, give the motions as segments"
        )
    try:
        found = segment_orders(segments, progress)
    except OutsideDomainError:
        raise RequestError(f"{model.file}: a coefficient is not seen to exist at the file's values") from None
    except KeyError as missing:
        reason = without_value(missing.args[0], (one.system for one in segments.parts))
        raise RequestError(f"{model.file}: {reason}") from None
    except TooManyBallStepsError:
        raise RequestError(f"{model.file}: a segment is too long to be followed in ball arithmetic") from None
    return SegmentPlan(model, segments.parts[0].system.n, found)


def orders_data(plan: SegmentPlan | None) -> Mapping[str, object]:
    """Return ``{"orders": …}``; nothing where none were looked for."""
    if plan is None:
        return {}
    found = plan.found
    return {
        "orders": {
            "model": {"name": plan.model.name, "file": str(plan.model.file)},
            "n": plan.n,
            "rank": found.rank,
            "target": found.target,
            "tried": found.tried,
            "complete": found.is_complete,
            "best": [_order(one) for one in found.best],
        }
    }


def _order(one: Order) -> dict[str, object]:
    return {"segments": list(one.names), "duration": json_number(one.duration), "at_least": list(one.after)}
