"""A factorial study: gradient of the light against rounding, for every estimator."""
