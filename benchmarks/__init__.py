"""Speeds as ratios; see `make bench`."""
