"""The variants that the bench measures: our own, and other programs for the same functions."""
