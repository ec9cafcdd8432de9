"""A capture made ready to be asked."""
