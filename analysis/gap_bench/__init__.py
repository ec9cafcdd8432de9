"""How good the diagnosis is: many captures with known causes, diagnosed, and counted.

cases      what is drawn, in one fixed shuffled order, so that any beginning is a fair sample
draw       cameras with random figures, and their captures
examine    one case through the diagnosis, as plain data
answers    what each of these is worth, and what is taken for what
share      so many of so many, with an interval
count      figures of the table from these
page       the same in words
run        cases one after the other, kept in a folder
published  results as they stand in the documentation, from which a fresh clone goes on

`make bench-gap` runs it and goes on where it stopped.
"""
