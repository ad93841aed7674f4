"""How well, not only whether: measures of observability, one a file, registered in ``catalogue``.

What a measure works on is a ``Subject``: a system at the file's values with its exact rank and verdicts, an
instant, and the units of the states. No measure decides what is observable; that is known exactly before.
"""
