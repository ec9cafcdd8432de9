"""Pages of the documentation that code writes.

A package of its own: a library that is installed may bring one of that name, which would be taken
for a folder without this file.
"""
