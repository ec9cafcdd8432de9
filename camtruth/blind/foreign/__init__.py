"""Effects from elsewhere. The diagnosis may not import this folder, and it imports none of ours:

outsider.py      what such an effect is
others_*.py      other people's code, by library; a library that is missing is said to be
strange_*.py     effects that are in no catalogue, in plain NumPy
library.py       all of them by name
"""
