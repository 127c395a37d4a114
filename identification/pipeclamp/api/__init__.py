"""The Python API: the commands as functions, with the same answers.

Results are objects with a short repr, tables in notebooks, `to_dict`, `to_frame` and `report`.
`import pipeclamp as pc` is the way in; nothing else of the project needs to be imported.
"""
