"""Withheld effects: captures with a sealed truth, answers that are hashed, and their score.

format        the documents of a set, as other programs read and write them
foreign/      effects from elsewhere: other people's code, and what no catalogue has
worn          such an effect in one of our cameras
design        which cases a set has, drawn from a secret
ruler         how severe an effect is, told without any diagnosis
making        the captures and the seal
answering     a diagnosis over the set, one gap report per case
baselines     two plain diagnoses to be beaten
marks         what one answer is worth
table         all of them, by severity, with intervals
splitting     a real capture into fair halves
"""
