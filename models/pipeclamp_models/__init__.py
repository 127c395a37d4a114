"""The physics of the clamp and of the pipe: effects' equations, the law composed of them, its realisations, the pipe.

It knows no test data, no FMU and no screen.
Its packages, each importing only those before it: base, equations, effects, law, steps, realise, pipe.
"""
