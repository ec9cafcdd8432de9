"""Real against simulated: where a gap lies, which effect causes it, how far it shrinks.

Each folder imports only from those above it:

report.py    the answer as data
look/        a capture as measured samples, and what is looked at: one file per family of figures
camera/      the base camera, its light, and its twin: the same capture, simulated
calibrate/   the base camera from the capture itself; distances with what calibration takes up
ready/       a capture made ready, and what frames tell of single effects: files named after them
measure/     how far a capture is from a model, and what an effect would take off
suspects/    every effect at the strength that fits, and which of them is the likeliest
search/      effects added to the camera one after the other, each calibrated along with it
verdict/     how far to believe what was found, and what is said of it
diagnose.py  the whole

A capture goes through them in another order, which `diagnose.py` calls:

1. prepare    `ready.setting.look`: which frames, what they show (look/), which light (camera/)
2. calibrate  `diagnose.calibrated`: the base camera, and around it twins, errors and directions
3. measure    `measure.measured`: how far the capture is from that model
4. search     `search.follow`: what frames tell by themselves (ready/), every suspect (suspects/),
              the best one added, then measured again, while one may be named
5. decide     `verdict.conclude`: the word, the names, their probabilities, the report
"""
