"""What every folder stands on: errors for people, strict documents, safe files, arithmetic.

Nothing here knows about cameras.
"""
