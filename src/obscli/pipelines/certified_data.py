"""The certified rank as JSON values."""

from __future__ import annotations

from obscli.checks.certified_rank import CertifiedInstant, CertifiedRank


def certified_data(found: CertifiedRank | None) -> dict[str, object]:
    """Return ``{certified, certified_reason}``: an entry an instant; None where it was not asked for."""
    return {
        "certified": None if found is None else [_instant(one) for one in found.instants],
        "certified_reason": "" if found is None else found.reason,
    }


def _instant(one: CertifiedInstant) -> dict[str, object]:
    minor = one.minor
    return {
        "t": one.t,
        "rank": one.rank,
        "minor": minor and {"midpoint": minor.midpoint, "radius": minor.radius},
        "precision": minor and minor.precision,
        "samples": minor and minor.samples,
        "since": minor and minor.since,
        "reason": one.reason,
    }
