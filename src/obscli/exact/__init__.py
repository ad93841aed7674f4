"""The exact side: a differential field, elimination over it, proofs, critical values. No floats."""
