"""Captures out to other programs and in from them, with truth, checksums and a dataset card."""
