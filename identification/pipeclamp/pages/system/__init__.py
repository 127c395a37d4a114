"""Pages of systems: co-simulation, frequency response, studies, and what was measured on a pipe.

They take results of `pipeclamp_system` and of `pipeclamp_identification.on_pipe`, and give sections of a report.
"""
