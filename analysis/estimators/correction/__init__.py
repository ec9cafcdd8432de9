"""The steps of the corrected estimator, one per file."""
