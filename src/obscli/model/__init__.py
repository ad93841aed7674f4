"""Reading model files: YAML tree, expression grammar, sections, stages, and the ``Model`` they mean."""
