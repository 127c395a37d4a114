"""Tables of results: a row a test, with its frequency, amplitude, stiffness and loss angle, and no record.

Exports of elastomer test machines and of dynamic mechanical analysis are such. They are told from records, whose rows
are samples of a motion, and become a campaign of metrics.
"""
