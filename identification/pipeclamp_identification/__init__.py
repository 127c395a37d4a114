"""From measurements to a law and to what it lacks: campaigns, fits, comparison, diagnosis, tests on the pipe.

It prints nothing and draws nothing.
Its packages, each importing only those before it: signals, units, campaign, loops, fitting, comparison, diagnosis,
discovery, metrics_only, importing, on_pipe, attribution, planning, workflow.
"""
