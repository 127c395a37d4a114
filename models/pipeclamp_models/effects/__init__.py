"""The catalogue: one file per effect, which states its equation, source and looks once.

The folder is the registry; nothing else lists them.
`models/pipeclamp_models/equations/effect.py` says what a file must state.
"""
