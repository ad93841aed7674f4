"""Checks: one claim that can fail a file; the place where results are held against each other."""
