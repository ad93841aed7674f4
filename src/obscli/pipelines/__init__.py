"""One command's work a file: models in, reports out."""
