"""Nouns without algebra."""
