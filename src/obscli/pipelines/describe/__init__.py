"""Findings put into words: one section of the report a file, each a function from a finding to blocks."""
