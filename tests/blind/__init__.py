"""Blind campaigns: data with a hidden physical effect, made by code that shares nothing with `serpenoid`.

Reading order: `snake` (the robot), `schedule` (commands, actuation), `ground` (friction laws), `contact` and `motion`
(force balance), `cameras` (what is seen), `catalogue` (what can be hidden), `campaign` (the folder and its seal),
`records` (shapes and paths back from the data), `strength` and `separation` (F, S, S_ab), `score` (right or wrong),
`study` (many campaigns). The laws: EFFECTS.md.
"""
