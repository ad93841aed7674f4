"""Several runs that share constant states: what they determine together, how well, which suffice."""
