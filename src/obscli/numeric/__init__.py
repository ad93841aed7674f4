"""The numerical side: floating point only, no computer algebra; it does not know ``exact``."""
